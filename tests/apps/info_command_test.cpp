#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "events/made_recording.hpp"
#include "support/paths.hpp"
#include "support/real_recordings.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/run_folder.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;
const std::string vendor_folder = std::string(test::data_folder) + "/aedat4/";

std::size_t line_count(const std::string& text) { return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')); }

nlohmann::json info_of(const std::string& arguments) {
  const test::CommandResult result = run_tactile("info --json " + arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out).at("recordings");
}

const nlohmann::json& stream_of_type(const nlohmann::json& recording, const std::string& type) {
  for (const nlohmann::json& stream : recording.at("streams")) {
    if (stream.at("type") == type) return stream;
  }
  throw std::runtime_error("no stream of " + type);
}

TEST(InfoCommand, ShowsWhatTheVendorsFilesContain) {
  const nlohmann::json truth = read_json(vendor_folder + "truth.json");
  for (const auto& [name, expected] : truth.items()) {
    const nlohmann::json recording = info_of(vendor_folder + name + ".aedat4").at(0);
    EXPECT_EQ(recording.at("camera"), expected.at("source").get<std::string>());
    EXPECT_EQ(recording.at("width"), expected.at("width"));
    EXPECT_EQ(recording.at("height"), expected.at("height"));
    EXPECT_EQ(recording.at("file_bytes"), expected.at("bytes"));
    EXPECT_EQ(recording.at("data_table").at("state"), "used");
    EXPECT_EQ(recording.at("healthy"), true);
    const nlohmann::json events = stream_of_type(recording, "events");
    EXPECT_EQ(events.at("elements"), expected.at("events"));
    EXPECT_EQ(events.at("on"), expected.at("on"));
    EXPECT_EQ(events.at("packets"), expected.at("event_packets"));
    EXPECT_EQ(events.at("first_us"), expected.at("first_us"));
    EXPECT_EQ(events.at("last_us"), expected.at("last_us"));
    const double seconds = (expected.at("last_us").get<double>() - expected.at("first_us").get<double>()) / 1e6;
    EXPECT_NEAR(events.at("rate_hz"), expected.at("events").get<double>() / seconds, 1e-3);
    if (expected.contains("imu")) {
      EXPECT_EQ(stream_of_type(recording, "imu").at("elements"), expected.at("imu"));
      EXPECT_EQ(stream_of_type(recording, "frames").at("elements"), expected.at("frames"));
      EXPECT_EQ(stream_of_type(recording, "triggers").at("elements"), expected.at("triggers"));
    }
  }
}

// What is in them was found by decoders of other projects.
TEST(InfoCommand, ShowsWhatARealDvxplorerRecordingContains) {
  const std::string file = test::real_recording("tonic-sample.aedat4").string();
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("tonic-sample.aedat4");
  const nlohmann::json recording = info_of("'" + file + "'").at(0);
  EXPECT_EQ(recording.at("camera"), "DVXplorer_DXB00010");
  EXPECT_EQ(recording.at("width"), 320);
  EXPECT_EQ(recording.at("height"), 240);
  EXPECT_EQ(recording.at("compression"), "lz4");
  EXPECT_EQ(recording.at("packets"), 118);
  const nlohmann::json events = stream_of_type(recording, "events");
  EXPECT_EQ(events.at("elements"), 111954);
  EXPECT_EQ(events.at("on"), 55023);
  EXPECT_EQ(events.at("packets"), 59);
  EXPECT_EQ(events.at("duration_us"), 589917);
  EXPECT_EQ(events.at("first_us"), 1605537493718345);
  EXPECT_EQ(events.at("last_us"), 1605537494308262);
  EXPECT_EQ(events.at("steps_back_in_packets"), 0);
  EXPECT_EQ(events.at("steps_back_between_packets"), 0);
  EXPECT_EQ(events.at("attributes").at("tsOffset"), "1605507430438338");
  const nlohmann::json imu = stream_of_type(recording, "imu");
  EXPECT_EQ(imu.at("elements"), 475);
  EXPECT_EQ(imu.at("first_us"), 1605537493718788);
  EXPECT_EQ(imu.at("last_us"), 1605537494307448);
  EXPECT_EQ(stream_of_type(recording, "triggers").at("elements"), 0);
  EXPECT_EQ(recording.at("healthy"), true) << recording.at("reasons");
}

TEST(InfoCommand, ShowsWhatARealDavisRecordingContains) {
  const std::string file = test::real_recording("aestream-sample.aedat4").string();
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("aestream-sample.aedat4");
  const nlohmann::json recording = info_of("'" + file + "'").at(0);
  EXPECT_EQ(recording.at("camera"), "DAVIS346_00000104");
  EXPECT_EQ(recording.at("width"), 346);
  EXPECT_EQ(recording.at("height"), 260);
  EXPECT_EQ(recording.at("packets"), 40);
  const nlohmann::json events = stream_of_type(recording, "events");
  EXPECT_EQ(events.at("elements"), 117667);
  EXPECT_EQ(events.at("on"), 72363);
  EXPECT_EQ(events.at("duration_us"), 129999);
  EXPECT_EQ(stream_of_type(recording, "imu").at("elements"), 130);
  EXPECT_EQ(stream_of_type(recording, "frames").at("elements"), 3);
  const nlohmann::json triggers = stream_of_type(recording, "triggers");
  EXPECT_EQ(triggers.at("elements"), 15);
  EXPECT_EQ(triggers.at("first_us"), 1633953690976518);
  EXPECT_EQ(triggers.at("last_us"), 1633953691110744);
  EXPECT_EQ(recording.at("healthy"), true) << recording.at("reasons");
}

TEST(InfoCommand, NamesRecordingsBelowAFolderThatItDoesNotExamine) {
  const test::TemporaryFolder folder;
  const std::string recording = std::string(test::data_folder) + "/aedat4/dv-lz4.aedat4";
  for (const char* place :
       {"loose", "loose/monday", "loose/monday/a", ".hidden", "data/cup/01", "data/cup/notes", "data/a/b/c/d"}) {
    std::filesystem::create_directories(folder / place);
    const bool is_run = std::string(place) == "data/cup/01";
    std::filesystem::copy_file(recording, folder / place / (is_run ? "events.aedat4" : "take.aedat4"));
  }
  const auto not_examined = [&](const std::string& place) {
    const auto result = test::run_tactile("info --json " + place, folder.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("recordings").size(), 1U) << place;
    EXPECT_NE(result.err.find("not examined"), std::string::npos) << result.err;
    return json.at("not_examined");
  };
  EXPECT_EQ(not_examined("loose"), nlohmann::json({"loose/monday", "loose/monday/a"}));
  EXPECT_EQ(not_examined("data"), nlohmann::json({"data/a/b/c/d", "data/cup/notes"}));
  const auto all = test::run_tactile("info --json data/cup/01", folder.path());
  EXPECT_TRUE(nlohmann::json::parse(all.out).at("not_examined").empty()) << all.out;
  EXPECT_EQ(all.err.find("not examined"), std::string::npos) << all.err;
}

TEST(InfoCommand, KnowsASimulatedRunByItsCameraToo) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  ASSERT_EQ(run_tactile("label --quiet", folder.path()).exit_code, 0);
  std::filesystem::remove(folder / "data/fan/01/run.json");
  std::filesystem::remove(folder / "data/fan/01/truth.json");
  std::filesystem::copy_file(folder / "data/fan/01/events.aedat4", folder / "copy.aedat4");
  EXPECT_NE(run_tactile("info copy.aedat4", folder.path()).out.find("pixels, simulated"), std::string::npos);
  EXPECT_NE(run_tactile("info data/fan/01", folder.path()).out.find("pixels, simulated"), std::string::npos);
  const auto viewed = run_tactile("view --json copy.aedat4 --out copy.png", folder.path());
  EXPECT_EQ(nlohmann::json::parse(viewed.out).at("simulated"), true) << viewed.err;
  // Beside a run that names itself simulated it is no real one.
  const auto windows = run_tactile("windows --json", folder.path());
  EXPECT_EQ(windows.err.find("there are real"), std::string::npos) << windows.err;
}

TEST(InfoCommand, PrintsAReportForPeople) {
  const test::CommandResult result = run_tactile("info --verbose " + vendor_folder + "dv-lz4.aedat4");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.err.empty()) << result.err;
  const std::string brief = run_tactile("info " + vendor_folder + "dv-lz4.aedat4").out;
  EXPECT_LE(std::count(brief.begin(), brief.end(), '\n'), 15) << brief;
  EXPECT_NE(brief.find("\n  healthy\n"), std::string::npos) << brief;
  for (const char* words : {"DVXplorer_DXM00042, 160 x 120 pixels", "2023-11-14 22:13:31.000033 UTC",
                            "lz4, 16 packets, data table used", "44.2 % ON (2652)", "every 200 us", "\n  healthy\n"}) {
    EXPECT_NE(result.out.find(words), std::string::npos) << words << " in\n" << result.out;
  }
}

TEST(InfoCommand, TakesAFolderOfLooseRecordings) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "loose");
  fs::create_directories(folder / "empty");
  for (const char* name : {"dv-lz4.aedat4", "dv-zstd.aedat4"}) fs::copy_file(vendor_folder + name, folder / "loose" / name);
  std::ofstream(folder / "loose/notes.txt") << "of a day\n";
  const test::CommandResult result = run_tactile("info --check loose", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("2 of 2 healthy"), std::string::npos) << result.out;
  const test::CommandResult none = run_tactile("info empty", folder.path());
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("empty: no recording in it, nor runs below it"), std::string::npos) << none.err;
}

TEST(InfoCommand, CountsTimeFromTheFirstEventUnlessAskedForCameraTime) {
  const std::string command = "info " + vendor_folder + "dv-lz4.aedat4";
  const std::string since_first = run_tactile(command).out, camera = run_tactile(command + " --camera-time").out;
  EXPECT_NE(since_first.find(" 0.000000 s"), std::string::npos) << since_first;
  EXPECT_NE(camera.find(" 1700000011.000033 s"), std::string::npos) << camera;
}

TEST(InfoCommand, EndsWithTwoWhereACheckFailsAndNamesTheReasons) {
  const test::TemporaryFolder folder;
  fs::copy_file(vendor_folder + "dv-lz4.aedat4", folder / "cut.aedat4");
  fs::resize_file(folder / "cut.aedat4", 40'000);
  EXPECT_EQ(run_tactile("info cut.aedat4", folder.path()).exit_code, 0);
  const test::CommandResult result = run_tactile("info --check cut.aedat4 " + vendor_folder + "dv-none.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("cut.aedat4: truncated"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("dv-none"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("SICK"), std::string::npos) << result.out;
  EXPECT_EQ(run_tactile("info --check " + vendor_folder + "dv-none.aedat4").exit_code, 0);
}

TEST(InfoCommand, TakesARecordingThatWasNeverClosedForHealthy) {
  const test::TemporaryFolder folder;
  fs::copy_file(vendor_folder + "dv-lz4.aedat4", folder / "open.aedat4");
  test::cut_off_table(folder / "open.aedat4");
  const test::CommandResult result = run_tactile("info --check open.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("data table missing"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("never closed"), std::string::npos) << result.out;
}

TEST(InfoCommand, ReportsTheRestIfAFileCannotBeRead) {
  const test::TemporaryFolder folder;
  write_whole(folder / "text.aedat4", "no recording at all");
  const test::CommandResult result =
      run_tactile("info none.aedat4 " + vendor_folder + "dv-lz4.aedat4 text.aedat4 --check", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(line_count(result.err), 2U) << result.err;
  EXPECT_NE(result.err.find("none.aedat4"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("text.aedat4"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("dv-lz4.aedat4"), std::string::npos) << result.out;
  const test::CommandResult json = run_tactile("info --json none.aedat4 " + vendor_folder + "dv-lz4.aedat4", folder.path());
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("recordings").size(), 1U);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("failed").at(0).at("file"), "none.aedat4");
}

TEST(InfoCommand, DoesNotAllocateForASensorOfAbsurdSize) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer's shadow takes more than this limit";
#endif
  const test::TemporaryFolder folder;
  events::RecordingWriter writer(folder / "huge.aedat4", {events::event_stream_declaration({32'767, 32'767}, "camera")});
  writer.write_events(0, test::steady_events(100, 0, 100, {32'767, 32'767}));
  writer.close();
  // Four bytes a pixel would be 4.3 GB; the libraries alone map a good gigabyte.
  const test::CommandResult result =
      test::run_shell("ulimit -v 4000000; '" + std::string(test::tactile_binary) + "' info --check huge.aedat4", folder.path());
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_NE(result.err.find("32767x32767 is not a valid sensor size"), std::string::npos) << result.err;
}

class InfoOfARun : public testing::Test {
 protected:
  InfoOfARun() {
    fs::create_directories(run.folder);
    fs::copy_file(vendor_folder + "dv-lz4.aedat4", run.events());
  }
  void describe(bool complete, int width, int height) {
    RunInfo info{.object = "fan",
                 .run = "03",
                 .session = "monday",
                 .simulated = false,
                 .complete = complete,
                 .width = width,
                 .height = height};
    write_run_info(run, info);
  }

  test::TemporaryFolder folder;
  RunFolder run{folder / "data" / "fan" / "03", "fan", "03"};
};

TEST_F(InfoOfARun, ShowsWhatRunJsonContains) {
  describe(true, 160, 120);
  const test::CommandResult result = run_tactile("info --check data/fan/03", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("fan/03, real, complete, session monday"), std::string::npos) << result.out;
  const nlohmann::json json = nlohmann::json::parse(run_tactile("info --json data", folder.path()).out);
  EXPECT_EQ(json.at("recordings").at(0).at("run").at("session"), "monday");
}

TEST_F(InfoOfARun, ShowsWhatTheOtherLogsContain) {
  describe(true, 160, 120);
  const nlohmann::json without = info_of("'" + run.folder.string() + "'").at(0);
  EXPECT_TRUE(without.at("robot").is_null());
  EXPECT_TRUE(without.at("video").is_null());
  write_whole(run.robot(), "a,timestamp\n1,0.000\n1,0.008\n\n1,3.000\n1,3.008\n1,3.0");
  write_whole(run.video_times(), "index,pts_us\n0,0\n1,40000\n2,80000\n");
  const nlohmann::json json = info_of("'" + run.folder.string() + "'").at(0);
  EXPECT_EQ(json.at("robot").at("rows"), 4) << "the last one is cut short";
  EXPECT_EQ(json.at("robot").at("gaps"), 1);
  EXPECT_NEAR(json.at("robot").at("rate_hz").get<double>(), 125, 1e-6);
  EXPECT_EQ(json.at("video").at("frames"), 3);
  EXPECT_NEAR(json.at("video").at("rate_hz").get<double>(), 25, 1e-9);
  const test::CommandResult text = run_tactile("info data/fan/03", folder.path());
  EXPECT_NE(text.out.find("robot       4 rows, 125 /s, 1 gap\n"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("video       3 frames, 25 /s\n"), std::string::npos) << text.out;
}

TEST_F(InfoOfARun, ComparesItsFilesWithWhatRunJsonLists) {
  write_whole(run.robot(), "timestamp\n1\n");
  RunInfo info{.object = "fan", .run = "03", .session = {}, .simulated = false, .complete = true, .width = 160, .height = 120};
  info.extra["files"] = files_json(std::array{run.events(), run.robot()});
  write_run_info(run, info);
  const test::CommandResult sound = run_tactile("info --check data/fan/03", folder.path());
  EXPECT_EQ(sound.exit_code, 0) << sound.err;
  EXPECT_NE(sound.out.find("2 of 2 as run.json lists them, by size and SHA-256"), std::string::npos) << sound.out;

  write_whole(run.robot(), "timestamp\n2\n");
  write_whole(run.video(), "film");
  const nlohmann::json cheap = info_of("'" + run.folder.string() + "'").at(0).at("run_files");
  EXPECT_EQ(cheap.at("compared"), "bytes");
  EXPECT_TRUE(cheap.at("changed").empty()) << "its size is the same";
  const test::CommandResult changed = run_tactile("info --check --json data/fan/03", folder.path());
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_NE(changed.err.find("robot.csv: has changed"), std::string::npos) << changed.err;
  const nlohmann::json files = nlohmann::json::parse(changed.out).at("recordings").at(0).at("run_files");
  EXPECT_EQ(files.at("compared"), "sha256");
  EXPECT_EQ(files.at("as_listed"), nlohmann::json{"events.aedat4"});
  EXPECT_EQ(files.at("changed"), nlohmann::json{"robot.csv"});
  EXPECT_EQ(files.at("not_listed"), nlohmann::json{"video.mp4"});

  fs::remove(run.robot());
  const test::CommandResult missing = run_tactile("info data/fan/03", folder.path());
  EXPECT_EQ(missing.exit_code, 0) << "without --check it only reports";
  EXPECT_NE(missing.out.find("robot.csv: is missing"), std::string::npos) << missing.out;
}

TEST_F(InfoOfARun, NotesWhatWasDropped) {
  RunInfo info{.object = "fan", .run = "03", .session = {}, .simulated = false, .complete = true, .width = 160, .height = 120};
  info.extra["dropped"] = {{"events", 1200}, {"packets", 1}, {"others", 0}, {"robot_gaps", 2}, {"frames", 0}};
  write_run_info(run, info);
  const test::CommandResult result = run_tactile("info --check data/fan/03", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("run.json counts as dropped: 1200 events, 1 packet, 2 robot gaps\n"), std::string::npos)
      << result.out;
}

TEST_F(InfoOfARun, IsSickWhereTheRunWasNotCompleted) {
  describe(false, 160, 120);
  const test::CommandResult result = run_tactile("info --check data/fan/03", folder.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("not completed"), std::string::npos) << result.err;
}

TEST_F(InfoOfARun, IsSickWhereTheSensorsSizeIsAnother) {
  describe(true, 640, 480);
  EXPECT_EQ(run_tactile("info --check data/fan/03", folder.path()).exit_code, 2);
}

TEST_F(InfoOfARun, IsSickWithoutRunJson) { EXPECT_EQ(run_tactile("info --check data/fan/03", folder.path()).exit_code, 2); }

TEST_F(InfoOfARun, FailsTheCheckWhereARunIsMisnamed) {
  describe(true, 160, 120);
  ASSERT_EQ(run_tactile("info --check data", folder.path()).exit_code, 0);
  fs::rename(folder / "data/fan/03", folder / "data/fan/3");
  const auto checked = run_tactile("info --check --json data", folder.path());
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_NE(checked.err.find("data/fan/3: is left out, because a run's name is two digits from 01 on; rename it to 03"),
            std::string::npos)
      << checked.err;
  EXPECT_EQ(nlohmann::json::parse(checked.out).at("misnamed").size(), 1U);
  EXPECT_EQ(run_tactile("info data", folder.path()).exit_code, 0);
  const auto typed = run_tactile("info --check data/fan/3", folder.path());
  EXPECT_EQ(typed.exit_code, 2);
  EXPECT_NE(typed.err.find("rename it to 03"), std::string::npos) << typed.err;
  fs::rename(folder / "data/fan/3", folder / "data/fan/03.discarded-1");
  EXPECT_EQ(run_tactile("info --check data/fan/03.discarded-1", folder.path()).exit_code, 0);
}

TEST_F(InfoOfARun, FailsTheCheckWhereARecordingIsMisnamed) {
  describe(true, 160, 120);
  fs::create_directories(folder / "data/fan/04");
  fs::rename(run.events(), folder / "data/fan/04/take.aedat4");
  const auto checked = run_tactile("info --check data", folder.path());
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_NE(checked.err.find("data/fan/04: is left out, because a run's recording is named events.aedat4; rename take.aedat4"),
            std::string::npos)
      << checked.err;
}

TEST_F(InfoOfARun, FailsTheCheckWhereARunHasNoRecording) {
  describe(true, 160, 120);
  fs::create_directories(folder / "data/fan/04");
  const auto checked = run_tactile("info --check --json data", folder.path());
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_NE(checked.err.find("left out, because events.aedat4 is missing: data/fan/04\n"), std::string::npos) << checked.err;
  const auto json = nlohmann::json::parse(checked.out);
  EXPECT_EQ(json.at("without_recording"), nlohmann::json::array({"data/fan/04"}));
  EXPECT_EQ(json.at("recordings").size(), 1U);
  EXPECT_EQ(run_tactile("info data", folder.path()).exit_code, 0) << "it only warns";
  EXPECT_EQ(run_tactile("info --check data/fan", folder.path()).exit_code, 2);
}

TEST_F(InfoOfARun, TakesTheFolderOfAnObjectForItsRuns) {
  describe(true, 160, 120);
  const auto result = run_tactile("info --check --json data/fan", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("recordings").size(), 1U);
}

TEST_F(InfoOfARun, ReportsTheOthersIfALinkLeadsToItself) {
  fs::create_symlink("04", folder / "data/fan/04");
  fs::create_symlink("loop", folder / "data/loop");
  const auto result = run_tactile("info --json data data/loop", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("recordings").size(), 1U);
  EXPECT_EQ(json.at("failed").size(), 3U) << result.out;
  EXPECT_EQ(result.err.find("filesystem error"), std::string::npos) << result.err;
}

TEST_F(InfoOfARun, IsSickWhereRunJsonIsNull) {
  write_json(folder / "data/fan/03/run.json", nullptr);
  const auto result = run_tactile("info --check data", folder.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("run.json: is null; expected an object"), std::string::npos) << result.err;
}

TEST_F(InfoOfARun, NeedsARecording) {
  fs::remove(run.events());
  const test::CommandResult result = run_tactile("info data/fan/03", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(line_count(result.err), 1U);
}

TEST(InfoCommand, RefusesAGapOutOfRange) {
  const test::CommandResult result = run_tactile("info --gap-ms 0 " + vendor_folder + "dv-lz4.aedat4");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("3600000"), std::string::npos) << result.err;
}

TEST(InfoCommand, ShowsOneLinePerRunOfAFolder) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_tactile("simulate data --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  const test::CommandResult brief = run_tactile("info --check data", folder.path());
  const std::size_t runs = find_runs(folder / "data").size();
  ASSERT_GT(runs, 1U);
  EXPECT_EQ(line_count(brief.out), runs + 2) << brief.out;
  EXPECT_NE(brief.out.find(std::to_string(runs) + " of " + std::to_string(runs) + " healthy\n"), std::string::npos) << brief.out;
  EXPECT_GT(line_count(run_tactile("info --verbose data", folder.path()).out), 10 * runs);

  fs::remove(folder / "data/fan/01/robot.csv");
  const test::CommandResult sick = run_tactile("info --check data", folder.path());
  EXPECT_EQ(sick.exit_code, 2);
  EXPECT_NE(sick.out.find(std::to_string(runs - 1) + " of " + std::to_string(runs) + " healthy\n"), std::string::npos)
      << sick.out;
}

}  // namespace
}  // namespace tactile::cli
