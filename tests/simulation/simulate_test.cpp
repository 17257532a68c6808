#include "tactile/simulation/simulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/videoio.hpp>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/truth.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;
using Kind = SimulatedRun::Kind;

/// Every file below a folder and its contents.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(folder)) {
    if (file.is_regular_file()) files[file.path().lexically_relative(folder).string()] = read_text(file.path());
  }
  return files;
}

std::vector<Kind> kinds(const std::vector<SimulatedRun>& outcomes) {
  std::vector<Kind> kinds;
  for (const SimulatedRun& outcome : outcomes) kinds.push_back(outcome.kind);
  return kinds;
}

SimulateOptions small(const fs::path& data) {
  return {.data = data, .preset = "tiny", .runs = 1, .objects = {"uhu-glue-stick"}, .threads = 1};
}

TEST(Simulate, WritesTheSameBytesOnAnyNumberOfThreadsAndOthersForAnotherSeed) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder / "one");
  options.objects = {"uhu-glue-stick", "sprayer"};
  simulate(options);
  options.data = folder / "two";
  options.threads = 2;
  simulate(options);
  const auto one = contents(folder / "one");
  EXPECT_EQ(one.size(), 12U) << "two runs of six files";
  EXPECT_EQ(one, contents(folder / "two"));
  options.data = folder / "other";
  options.seed = 2;
  simulate(options);
  const auto other = contents(folder / "other");
  for (const auto& [name, text] : one) EXPECT_NE(other.at(name), text) << name;
}

TEST(Simulate, MakesARunThatIsWholeAndSaysWhatItIs) {
  const test::TemporaryFolder folder;
  const SimulatedRun outcome = simulate(small(folder.path())).at(0);
  const std::vector<RunFolder> runs = find_runs(folder.path());
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].name(), "uhu-glue-stick/01");
  const RunInfo info = read_run_info(runs[0]);
  EXPECT_TRUE(info.simulated && info.complete);
  EXPECT_EQ(info.object, "uhu-glue-stick");
  EXPECT_EQ(info.width, 640);
  EXPECT_EQ(info.height, 480);
  for (const auto& [name, file] : info.extra.at("files").items()) {
    EXPECT_EQ(sha256_of_file(runs[0].folder / name), file.at("sha256").get<std::string>()) << name;
  }
  EXPECT_EQ(info.extra.at("files").size(), 5U);

  RecordingReader recording(runs[0].events());
  const Stream& stream = event_stream(recording);
  EXPECT_EQ(stream.source, "DVXplorer_SIM00001");
  EXPECT_EQ(recording.compression(), Compression::lz4);
  std::uint64_t events = 0;
  CameraTime first{}, last{};
  for_all_events(recording, stream.id, [&](std::span<const Event> batch) {
    if (events == 0) first = batch.front().t;
    last = batch.back().t;
    events += batch.size();
    for (const Event& event : batch) ASSERT_EQ((us_of(event.t) - us_of(first)) % 200, 0);
  });
  EXPECT_EQ(events, outcome.events);
  EXPECT_NEAR(static_cast<double>(us_of(last) - us_of(first)), 1e6 * outcome.duration_s, 2000.0);

  const Truth truth = read_truth(runs[0].truth());
  ASSERT_EQ(truth.intervals.size(), 2U);
  EXPECT_EQ(truth.intervals[0].interval.touch, Touch::press);
  EXPECT_EQ(truth.intervals[1].interval.touch, Touch::slip);
  EXPECT_LT(truth.intervals[0].interval.end, truth.intervals[1].interval.start);
  EXPECT_GT(truth.intervals[0].interval.start, first + 600ms);
  EXPECT_LT(truth.intervals[1].interval.end, last);

  const RobotLog robot = read_robot_log(runs[0].robot());
  const auto moving =
      std::find_if(robot.states.begin(), robot.states.end(), [](const RobotState& s) { return s.tcp_speed[2] > 0.003; });
  ASSERT_NE(moving, robot.states.end());
  const microseconds late = truth.robot_clock->camera_from(moving->t) - *truth.lift_start;
  EXPECT_GT(late, 0us);
  EXPECT_LT(late, 12ms) << "one period of 8 ms, and 3 ms until the speed stands out of its noise";
}

TEST(Simulate, WritesAFilmWhoseFramesHaveTheirTrueTimes) {
  const test::TemporaryFolder folder;
  simulate(small(folder.path()));
  const RunFolder run = find_runs(folder.path()).at(0);
  const std::vector<VideoTime> times = read_video_times(run.video_times());
  ASSERT_GT(times.size(), 60U);
  cv::VideoCapture film(run.video().string(), cv::CAP_FFMPEG);
  ASSERT_TRUE(film.isOpened());
  cv::Mat frame;
  for (std::size_t i = 0; i < times.size(); ++i) {
    ASSERT_TRUE(film.read(frame));
    EXPECT_NEAR(1000.0 * film.get(cv::CAP_PROP_POS_MSEC), static_cast<double>(us_of(times[i])), 0.5);
    EXPECT_EQ(frame.size(), cv::Size(320, 240));
  }
  EXPECT_FALSE(film.read(frame)) << "as many frames as rows";
}

TEST(Simulate, KeepsItsRunsRefusesItsOthersAndReplacesThemWhenForced) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.runs = 2;
  EXPECT_EQ(kinds(simulate(options)), (std::vector{Kind::made, Kind::made}));
  const fs::path first = folder / "uhu-glue-stick" / "01", second = folder / "uhu-glue-stick" / "02";
  write_whole(first / "labels.json", "{}");
  const auto before = contents(folder.path());
  EXPECT_EQ(kinds(simulate(options)), (std::vector{Kind::kept, Kind::kept}));
  EXPECT_EQ(contents(folder.path()), before) << "labels and all";

  options.seed = 2;
  EXPECT_THROW(simulate(options), Error);
  EXPECT_EQ(contents(folder.path()), before) << "refused before anything is touched";

  options.force = true;
  options.runs = 1;
  EXPECT_EQ(kinds(simulate(options)), (std::vector{Kind::replaced, Kind::removed}));
  EXPECT_FALSE(fs::exists(second));
  EXPECT_FALSE(fs::exists(first / "labels.json")) << "they were of the run that is gone";
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::kept});

  fs::remove(first / "video.mp4");
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::replaced}) << "a run of its own that lacks a file is made again";
}

TEST(Simulate, NeverTouchesARunThatIsNotItsOwn) {
  const test::TemporaryFolder folder;
  const fs::path real = folder / "uhu-glue-stick" / "01", other = folder / "uhu-glue-stick" / "02";
  write_whole(real / "events.aedat4", "a real recording");
  write_whole(
      real / "run.json",
      R"({"object": "uhu-glue-stick", "run": "01", "simulated": false, "complete": true, "sensor": {"width": 640, "height": 480}})");
  write_whole(other / "notes.txt", "mine");
  const auto before = contents(folder.path());
  SimulateOptions options = small(folder.path());
  options.force = true;
  EXPECT_THROW(simulate(options), Error);
  EXPECT_EQ(contents(folder.path()), before);
  options.objects = {"fan"};
  simulate(options);
  EXPECT_EQ(read_text(real / "events.aedat4"), "a real recording");
  EXPECT_EQ(read_text(other / "notes.txt"), "mine");
}

TEST(Simulate, LeavesNoHalfARunWhenItIsEnded) {
  const test::TemporaryFolder folder;
  struct Ended {};
  const auto end_half_way = [](const Progress& progress) {
    EXPECT_EQ(progress.what, "uhu-glue-stick/01");
    if (2 * progress.done > progress.total) throw Ended{};
  };
  EXPECT_THROW(simulate(small(folder.path()), end_half_way), Ended);
  EXPECT_TRUE(contents(folder.path()).empty());
}

TEST(Simulate, RefusesWhatItDoesNotKnow) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.objects = {"cup"};
  EXPECT_THROW(simulate(options), Error);
  options = small(folder.path());
  options.preset = "huge";
  EXPECT_THROW(simulate(options), Error);
  options = small(folder.path());
  options.runs = 0;
  EXPECT_THROW(simulate(options), Error);
}

}  // namespace
}  // namespace tactile
