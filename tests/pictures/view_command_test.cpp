#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/comes_true.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/pictures/drawing.hpp"
#include "windows/made_runs.hpp"

namespace tactile::pictures {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

const std::string recordings = std::string("'") + test::data_folder + "/aedat4/";

nlohmann::json json_of(const test::CommandResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result.exit_code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json();
}

/// How many frames of this colour a picture has: areas of it that hang together and are as large as a frame.
int frames_of(const cv::Mat& picture, const std::optional<Touch>& touch) {
  cv::Mat found, labels, numbers, middles;
  cv::inRange(picture, touch_colour(touch), touch_colour(touch), found);
  const int count = cv::connectedComponentsWithStats(found, labels, numbers, middles);
  int frames = 0;
  for (int i = 1; i < count; ++i) frames += numbers.at<int>(i, cv::CC_STAT_HEIGHT) > 100 ? 1 : 0;
  return frames;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// fan/01 in `data`, of 1.5 s: a press from 200 to 260 ms, a slip from 700 to 900 ms.
class ViewCommand : public testing::Test {
 protected:
  ViewCommand() { test::make_run(folder / "data", run); }

  test::CommandResult view(const std::string& arguments) const { return run_tactile("view " + arguments, folder.path()); }
  /// The run's events in [t - length, t).
  std::int64_t events_before(std::int64_t t_us, microseconds length) const {
    const CameraTime t = camera_time(t_us);
    return std::count_if(events.begin(), events.end(),
                         [&](const events::Event& event) { return event.t >= t - length && event.t < t; });
  }
  bool has_leftovers() const {
    const std::vector<std::string> names = names_in(folder.path());
    return std::any_of(names.begin(), names.end(), [](const std::string& name) { return name.front() == '.'; });
  }

  test::TemporaryFolder folder;
  test::LabelledRun run;
  std::vector<events::Event> events = test::random_events(run);
};

TEST_F(ViewCommand, DrawsRecordingsOfAnySensor) {
  for (const std::string name : {"dv-none", "dv-lz4", "dv-zstd-high", "dv-events-only"}) {
    const auto json = json_of(view(recordings + name + ".aedat4' --th 10 --out sheet.png --json"));
    const int width = json.at("sensor").at("width");
    EXPECT_EQ(json.at("heatmap").at("width"), width / 5);
    EXPECT_FALSE(json.at("labelled").get<bool>());
    for (const auto& tile : json.at("tiles")) {
      EXPECT_GT(tile.at("events"), 1000);
      EXPECT_EQ(tile.at("t_us").get<std::int64_t>() % 2000, 0);
      EXPECT_TRUE(tile.at("label").is_null());
    }
    const cv::Mat sheet = cv::imread((folder / "sheet.png").string());
    EXPECT_EQ(frames_of(sheet, std::nullopt), 3 * static_cast<int>(json.at("tiles").size()));
  }
}

TEST_F(ViewCommand, CountsTheEventsOfEachWindow) {
  const auto json = json_of(view("data/fan/01/events.aedat4 --th 40 --tiles 7 --out sheet.png --json"));
  const auto& tiles = json.at("tiles");
  ASSERT_EQ(tiles.size(), 7U);
  EXPECT_EQ(json.at("simulated"), read_run_info(run_folder_at(folder / "data/fan/01")).simulated);
  for (const auto& tile : tiles) {
    const std::int64_t t = tile.at("t_us");
    EXPECT_EQ(tile.at("events").get<std::int64_t>(), events_before(t, 40ms));
    EXPECT_NEAR(tile.at("since_first_event_ms"), static_cast<double>(t - us_of(events.front().t)) / 1000, 1e-9);
    EXPECT_GT(tile.at("most_per_pixel"), 1);
    EXPECT_LT(tile.at("most_per_pixel"), 20);
  }
  EXPECT_EQ(frames_of(cv::imread((folder / "sheet.png").string()), std::nullopt), 3 * 7);
}

TEST_F(ViewCommand, ShowsALabelledRunAroundItsOnsets) {
  const auto json = json_of(view("data/fan/01 --out sheet.png --json"));
  std::vector<std::string> labels;
  for (const auto& tile : json.at("tiles")) labels.push_back(tile.at("label"));
  EXPECT_EQ(labels, (std::vector<std::string>{"none", "press", "press", "none", "none", "none", "none", "slip", "slip", "slip",
                                              "slip", "none"}));
  const cv::Mat sheet = cv::imread((folder / "sheet.png").string());
  EXPECT_EQ(frames_of(sheet, Touch::press), 3 * 2);
  EXPECT_EQ(frames_of(sheet, Touch::slip), 3 * 4);
  EXPECT_EQ(frames_of(sheet, Touch::none), 3 * 6);
}

TEST_F(ViewCommand, NamesASheetForItsRecordingByDefault) {
  EXPECT_EQ(json_of(view("data/fan/01 --json")).at("out"), "fan-01.png");
  EXPECT_EQ(json_of(view("data/fan/01/events.aedat4 --json")).at("out"), "events.png");
  EXPECT_TRUE(fs::exists(folder / "fan-01.png"));
  EXPECT_TRUE(fs::exists(folder / "events.png"));
}

TEST_F(ViewCommand, ShowsEvenlySpacedMomentsOfALabelledRunWhereAskedFor) {
  const auto spaced = json_of(view("data/fan/01 --tiles 5 --out sheet.png --json")).at("tiles");
  ASSERT_EQ(spaced.size(), 5U);
  EXPECT_EQ(spaced.front().at("label"), "none");
  const auto stretch = json_of(view("data/fan/01 --from-ms 700 --to-ms 800 --tiles 6 --out sheet.png --json")).at("tiles");
  ASSERT_EQ(stretch.size(), 6U);
  EXPECT_NEAR(stretch.front().at("since_first_event_ms"), 700, 2);
  EXPECT_NEAR(stretch.back().at("since_first_event_ms"), 800, 2);
  for (const auto& tile : stretch) {
    const double ms = tile.at("since_first_event_ms");
    EXPECT_GE(ms, 700);
    EXPECT_LE(ms, 800);
    EXPECT_EQ(tile.at("label"), "slip") << ms;
  }
}

TEST_F(ViewCommand, FilmsAllTouchesAtTheSpeedAskedFor) {
  const auto json = json_of(view("data/fan/01 --out film.mp4 --speed 0.25 --fps 20 --json"));
  // 250 ms before 200 ms is ahead of the first full history, at 40 ms; 900 ms and 250 are the end. 12.5 ms from one to the next.
  EXPECT_NEAR(json.at("from_ms"), 41, 2);
  EXPECT_NEAR(json.at("to_ms"), 1150, 14);
  const int pictures = json.at("pictures");
  EXPECT_NEAR(pictures, (1150 - 41) / 12.5, 2);
  EXPECT_NEAR(json.at("seconds"), pictures / 20.0, 1e-9);
  cv::VideoCapture film((folder / "film.mp4").string());
  EXPECT_NEAR(film.get(cv::CAP_PROP_FPS), 20, 0.01);
  EXPECT_EQ(json.at("width"), film.get(cv::CAP_PROP_FRAME_WIDTH));
  EXPECT_EQ(json.at("height"), film.get(cv::CAP_PROP_FRAME_HEIGHT));
  int count = 0, none = 0, press = 0, slip = 0;
  for (cv::Mat picture; film.read(picture); ++count) {
    // The upper edge of the frame of the heatmap, whose colours the encoder changes a little.
    const cv::Vec3b edge = picture.at<cv::Vec3b>(101, picture.cols - 200);
    const auto is = [&](Touch touch) { return cv::norm(cv::Scalar(edge), touch_colour(touch) + cv::Scalar(0, 0, 0, 0)) < 40; };
    none += is(Touch::none) ? 1 : 0;
    press += is(Touch::press) ? 1 : 0;
    slip += is(Touch::slip) ? 1 : 0;
  }
  EXPECT_EQ(count, pictures);
  EXPECT_EQ(none + press + slip, pictures);
  EXPECT_NEAR(press, 60 / 12.5, 1.1);
  EXPECT_NEAR(slip, 200 / 12.5, 1.1);
  EXPECT_FALSE(has_leftovers());
}

TEST_F(ViewCommand, FilmsWhatItIsAskedForAndStandsStillBetweenTicks) {
  const auto stretch = json_of(view("data/fan/01 --out film.mp4 --from-ms 1300 --to-ms 1340 --speed 0.1 --json"));
  EXPECT_NEAR(stretch.at("from_ms"), 1301, 1);
  EXPECT_NEAR(stretch.at("to_ms"), 1339, 2);
  EXPECT_NEAR(stretch.at("pictures"), 10, 1);
  const auto slow = json_of(view("data/fan/01 --out slow.mp4 --from-ms 1300 --to-ms 1340 --speed 0.01 --json"));
  EXPECT_NEAR(slow.at("pictures"), 98, 4);  // of 20 ticks, 5 pictures each
  EXPECT_GT(slow.at("seconds"), 3.5);
  const auto fast = json_of(view("data/fan/01/events.aedat4 --out fast.mp4 --speed 4 --fps 10 --json"));
  EXPECT_EQ(fast.at("pictures"), 4) << "0, 400, 800 and 1200 ms after the first full tick";
}

TEST_F(ViewCommand, WritesAPictureForEachTickInOrder) {
  const auto json = json_of(view("data/fan/01 --out pictures --from-ms 190 --to-ms 230 --speed 0.01 --json"));
  const std::size_t count = json.at("pictures");
  EXPECT_NEAR(static_cast<double>(count), 20, 1);
  std::vector<std::string> expected;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    expected.push_back("picture-" + std::string(6 - number.size(), '0') + number + ".png");
  }
  std::ifstream list(folder / "pictures/pictures.csv");
  std::string line;
  std::getline(list, line);
  EXPECT_EQ(line, "file,t_us,since_first_event_ms,events,label");
  std::int64_t before = 0;
  for (const std::string& name : expected) {
    const cv::Mat picture = cv::imread((folder / ("pictures/" + name)).string());
    EXPECT_EQ(picture.cols, json.at("width").get<int>());
    ASSERT_TRUE(std::getline(list, line));
    std::istringstream cells(line);
    std::string file, t, ms, number, label;
    std::getline(std::getline(std::getline(std::getline(std::getline(cells, file, ','), t, ','), ms, ','), number, ','), label);
    EXPECT_EQ(file, name);
    EXPECT_GT(std::stoll(t), before);
    before = std::stoll(t);
    EXPECT_EQ(std::stoll(number), events_before(before, 40ms));
    EXPECT_EQ(label, std::stod(ms) > 201 ? "press" : std::stod(ms) < 200 ? "none" : label);
    EXPECT_EQ(frames_of(picture, touch_named(label)), 2) << name;
  }
  EXPECT_FALSE(std::getline(list, line));
  expected.emplace_back("pictures.csv");
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(names_in(folder / "pictures"), expected);

  // Made again with fewer, none of the old ones are left.
  json_of(view("data/fan/01 --out pictures/ --from-ms 190 --to-ms 194 --json"));
  EXPECT_LE(names_in(folder / "pictures").size(), 4U);
  EXPECT_FALSE(has_leftovers());
}

TEST_F(ViewCommand, LeavesAFolderWithOtherFilesAlone) {
  fs::create_directories(folder / "mine");
  write_whole(folder / "mine/thesis.tex", "precious");
  const auto refused = view("data/fan/01 --out mine");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("mine: holds thesis.tex"), std::string::npos) << refused.err;
  EXPECT_EQ(names_in(folder / "mine"), std::vector<std::string>{"thesis.tex"});
}

TEST_F(ViewCommand, LeavesNothingHalfWrittenAfterCtrlC) {
  write_whole(folder / "old.mp4", "a film of yesterday");
  for (const std::string out : {"old.mp4", "new.mp4", "pictures"}) {
    test::RunningCommand command("view data/fan/01 --speed 0.0001 --tick-us 40 --from-ms 100 --to-ms 1100 --out " + out,
                                 folder.path());
    EXPECT_TRUE(test::comes_true([&] { return has_leftovers() || command.has_ended(); }));
    command.signal(SIGINT);
    const auto result = command.wait();
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_FALSE(has_leftovers()) << out;
  }
  EXPECT_EQ(read_text(folder / "old.mp4"), "a film of yesterday");
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"data", "old.mp4"}));
}

TEST_F(ViewCommand, ClearsWhatAKilledOneLeft) {
  for (const std::string out : {"film.mp4", "pictures"}) {
    test::RunningCommand command("view data/fan/01 --speed 0.0001 --tick-us 40 --from-ms 100 --to-ms 1100 --out " + out,
                                 folder.path());
    EXPECT_TRUE(test::comes_true([&] { return has_leftovers() || command.has_ended(); }));
    command.signal(SIGKILL);
    command.wait();
    EXPECT_FALSE(fs::exists(folder / out));
    EXPECT_TRUE(has_leftovers());
    json_of(view("data/fan/01 --from-ms 100 --to-ms 110 --json --out " + out));
    EXPECT_FALSE(has_leftovers()) << out;
  }
}

TEST_F(ViewCommand, GivesTheSameBytesWhateverTheThreads) {
  for (const std::string out : {"sheet.png", "film.mp4"}) {
    ASSERT_EQ(view("data/fan/01 --to-ms 300 --threads 1 --out " + out).exit_code, 0);
    const std::string once = read_text(folder / out);
    ASSERT_EQ(view("data/fan/01 --to-ms 300 --threads 3 --out " + out).exit_code, 0);
    EXPECT_EQ(read_text(folder / out), once) << out;
  }
}

TEST_F(ViewCommand, RefusesInWordsWhatCannotBeShown) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {recordings + "dv-lz4.aedat4' --th 40 --out sheet.png", "less than one full history of 40 ms"},
      {recordings + "dv-lz4.aedat4' --th 10 --stream 99 --out sheet.png", "99"},
      {recordings + "truth.json' --out sheet.png", "truth.json"},
      {"data/fan/01 --out film.avi", ".avi is not a form of view; expected .png for a contact sheet, .mp4 for a film"},
      {"data/fan/01 --out sheet.png --fps 30", "--fps: sheet.png is a contact sheet; expected it for films"},
      {"data/fan/01 --speed 0.1", "--speed: the output is a contact sheet"},
      {"data/fan/01 --out film.mp4 --tiles 3", "--tiles: film.mp4 is a film; expected it for contact sheets"},
      {"data/fan/01 --out pictures --tiles 3", "--tiles: pictures is a folder"},
      {"data/fan/01 --from-ms 500 --to-ms 400", "--from-ms 500: is after --to-ms 400"},
      {"data/fan/01 --from-ms 5000", "--from-ms 5000: there is no tick with a full history; expected times between 4"},
      {"data/fan/01 --to-ms 5", "--to-ms 5: there is no tick"},
      {"data/fan/01 --from-ms 500 --to-ms 500.001", "there is no tick"},
      {"data/fan/01 --out film.mp4 --speed 0.0001 --fps 240", "pictures; expected at most 1000000"},
      {"data --out sheet.png", "fan/01"}};
  for (const auto& [arguments, words] : wrong) {
    const auto result = view(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments << result.out;
    EXPECT_NE(result.err.find(words), std::string::npos) << arguments << ": " << result.err;
  }
  EXPECT_GE(view("nowhere --out sheet.png").exit_code, 100);
  EXPECT_GE(view("data/fan/01 --from-ms -1").exit_code, 100);
  EXPECT_GE(view("data/fan/01 --out film.mp4 --speed 0").exit_code, 100);
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"data"});
}

TEST_F(ViewCommand, NamesTheBagThatAPersonKnows) {
  const fs::path bags = fs::path(test::data_folder) / "bags";
  fs::create_directory(folder / "bag");
  fs::copy_file(bags / "mono.db3", folder / "bag" / "mono.db3");
  for (const std::string& bag : {(bags / "mono.bag").string(), std::string("bag")}) {
    const test::CommandResult refused = view("'" + bag + "' --out sheet.png --th 90000");
    EXPECT_EQ(refused.exit_code, 1) << refused.out;
    EXPECT_NE(refused.err.find("tactile: " + bag + ": is "), std::string::npos) << refused.err;
    EXPECT_EQ(refused.err.find(".part-"), std::string::npos) << refused.err;
  }
}

TEST_F(ViewCommand, NamesAMaskThatDoesNotFit) {
  write_whole(folder / "far.csv", "x,y\n700,3\n");
  const test::CommandResult refused = view("data/fan/01 --out sheet.png --mask far.csv");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("far.csv: pixel (700, 3) lies outside the sensor"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace tactile::pictures
