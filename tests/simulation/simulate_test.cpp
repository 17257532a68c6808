#include "tactile/simulation/simulate.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "support/error_of.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::simulation {
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
  kinds.reserve(outcomes.size());
  for (const SimulatedRun& outcome : outcomes) kinds.push_back(outcome.kind);
  return kinds;
}

std::vector<TrueInterval> labelled_in(const Truth& truth) {
  std::vector<TrueInterval> labelled;
  std::copy_if(truth.intervals.begin(), truth.intervals.end(), std::back_inserter(labelled),
               [](const TrueInterval& interval) { return interval.labelled; });
  return labelled;
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

/// The distance of a stamp without the scan from the nearest read-out; a stamp is rounded down.
double off_readout_us(const events::Event& event, CameraTime start, double readout_us) {
  const EventCameraOptions& camera = default_physics().camera;
  const double scan_us = camera.scan_us_per_column * (camera.size.width - 1 - event.x);
  return std::abs(std::remainder(static_cast<double>((event.t - start).count()) + 0.5 - scan_us, readout_us));
}

TEST(Simulate, MakesACompleteAndDescribedRun) {
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

  events::RecordingReader recording(runs[0].events());
  const events::Stream& stream = events::event_stream(recording);
  EXPECT_EQ(stream.source, "DVXplorer_SIM00001");
  EXPECT_EQ(recording.compression(), events::Compression::lz4);
  std::uint64_t events = 0;
  CameraTime first{}, last{};
  const auto readout_us = info.extra.at("camera").at("readout_us").get<double>();
  const auto start_us = read_truth(runs[0].truth()).parameters.at("camera_start_us").get<std::int64_t>();
  events::for_all_events(recording, stream.id, [&](std::span<const events::Event> batch) {
    if (events == 0) first = batch.front().t;
    last = batch.back().t;
    events += batch.size();
    for (const events::Event& event : batch)
      ASSERT_LT(off_readout_us(event, camera_time(start_us), readout_us), 2.0) << "it wanders by 0.2 us";
  });
  EXPECT_EQ(events, outcome.events);
  EXPECT_NEAR(static_cast<double>(us_of(last) - us_of(first)), 1e6 * outcome.duration_s, 2000.0);

  const Truth truth = read_truth(runs[0].truth());
  const std::vector<TrueInterval> labelled = labelled_in(truth);
  ASSERT_EQ(labelled.size(), 2U);
  EXPECT_EQ(labelled[0].what, "press");
  EXPECT_EQ(labelled[0].interval.touch, Touch::press);
  EXPECT_EQ(labelled[1].what, "slip");
  EXPECT_EQ(labelled[1].interval.touch, Touch::slip);
  EXPECT_LT(labelled[0].interval.end, labelled[1].interval.start);
  EXPECT_GT(labelled[0].interval.start, first + 600ms);
  EXPECT_LT(labelled[1].interval.end, last);
  const nlohmann::json& camera = truth.parameters.at("camera");
  EXPECT_EQ(truth.hot_pixels.size(), camera.at("hot_pixels").get<std::size_t>() + camera.at("stuck_pixels").get<std::size_t>());
  EXPECT_EQ(camera.at("readout_us"), readout_us) << "the session's camera";
  EXPECT_EQ(truth.dead_pixels.size(), static_cast<std::size_t>(default_physics().camera.dead_pixels));
  EXPECT_EQ(truth.parameters.at("physics_hash"), hash_of(json_of(default_physics())));
  EXPECT_EQ(info.extra.at("simulation").at("physics").at("source"), "default");

  const robot::RobotLog robot = robot::read_robot_log(runs[0].robot()).longest();
  const auto moving =
      std::find_if(robot.states.begin(), robot.states.end(), [](const robot::RobotState& s) { return s.tcp_speed[2] > 0.003; });
  ASSERT_NE(moving, robot.states.end());
  const microseconds late = truth.robot_clock->camera_from(moving->t) - *truth.lift_start;
  EXPECT_GT(late, 0us);
  EXPECT_LT(late, 12ms) << "one period of 8 ms, and 3 ms until the speed stands out of its noise";
}

TEST(Simulate, WritesATruthThatFitsItsEvents) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.objects = {"3d-printed-object", "plastic-container", "white-box"};
  for (const SimulatedRun& made : simulate(options)) {
    const Truth truth = read_truth(made.run.truth());
    const std::vector<events::Event> events = test::events_in_file(made.run.events());
    const auto rate = [&](CameraTime begin, CameraTime end) {
      const auto is_within = [&](const events::Event& event) { return begin <= event.t && event.t < end; };
      return static_cast<double>(std::count_if(events.begin(), events.end(), is_within)) /
             (1e-6 * static_cast<double>((end - begin).count()));
    };
    std::uint64_t touch_events = 0;
    for (const TrueInterval& interval : labelled_in(truth)) {
      const auto [touch, start, end] = interval.interval;
      EXPECT_GT(rate(start, end), 1.2 * rate(start - 100ms, start - 20ms)) << made.run.name() << ": " << interval.what;
      touch_events += static_cast<std::uint64_t>(std::count_if(
          events.begin(), events.end(), [&, from = start, to = end](const events::Event& e) { return from <= e.t && e.t < to; }));
    }
    EXPECT_EQ(made.touch_events, touch_events);
    for (const TrueInterval& interval : truth.intervals) {
      ASSERT_TRUE(interval.first_event || !interval.labelled);
      if (!interval.first_event) continue;
      EXPECT_GE(*interval.first_event, interval.interval.start) << interval.what;
      EXPECT_TRUE(std::binary_search(events.begin(), events.end(), events::Event{.t = *interval.first_event},
                                     [](const events::Event& a, const events::Event& b) { return a.t < b.t; }))
          << interval.what;
    }
    std::map<std::pair<int, int>, int> counts;
    for (const events::Event& event : events) ++counts[{event.x, event.y}];
    std::size_t busier = 0;  // markers move over some hot pixels
    for (const TruePixel& hot : truth.hot_pixels) {
      const double expected = hot.hz * made.duration_s, unsure = 0.1 * expected + 6 * std::sqrt(expected);
      const int count = counts[{hot.x, hot.y}];
      EXPECT_GT(count, expected - unsure) << hot.x << ", " << hot.y;
      busier += count > expected + unsure + 30 ? 1 : 0;
    }
    EXPECT_LT(busier, 0.02 * static_cast<double>(truth.hot_pixels.size()));
    for (const TruePixel& dead : truth.dead_pixels) EXPECT_EQ((counts[{dead.x, dead.y}]), 0);
  }
}

TEST(Simulate, AddsTheInertialSensorsStreamToHalfOfTheRuns) {
  const SimulationPhysics& physics = default_physics();
  int with_imu = 0;
  std::array<std::string, 2> found;  // an object whose first run has none, and one whose has
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const ObjectModel& object : physics.objects) {
      Random random(seed_for(seed, {object.name}));
      with_imu += draw_run_plan(object, physics.plan_options(physics.preset("tiny"), 1), random).has_imu ? 1 : 0;
    }
  }
  EXPECT_NEAR(with_imu, 100, 30);
  for (const ObjectModel& object : physics.objects)
    found.at(draw_run(physics, object.name, "01", "tiny", 1).plan.has_imu ? 1 : 0) = object.name;

  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.objects = {found[0], found[1]};
  simulate(options);
  EXPECT_EQ(events::RecordingReader(folder / found[0] / "01" / "events.aedat4").streams().size(), 1U);
  events::RecordingReader recording(folder / found[1] / "01" / "events.aedat4");
  ASSERT_EQ(recording.streams().size(), 2U);
  EXPECT_EQ(recording.stream(1).type, events::StreamType::imu);
  std::vector<events::ImuSample> samples;
  CameraTime last_begin = CameraTime::min();
  microseconds furthest_back{};
  for (const events::PacketRecord& packet : recording.packets()) {
    furthest_back = std::max(furthest_back, packet.first < last_begin ? last_begin - packet.first : 0us);
    last_begin = std::max(last_begin, packet.first);
    if (packet.stream_id != 1) continue;
    const std::vector<events::ImuSample> part = recording.read_imu(packet);
    samples.insert(samples.end(), part.begin(), part.end());
  }
  EXPECT_LT(furthest_back, 50ms) << "packets of both streams lie side by side";
  const std::vector<events::Event> events = test::events_in_file(folder / found[1] / "01" / "events.aedat4");
  ASSERT_FALSE(samples.empty());
  const double seconds = 1e-6 * static_cast<double>((events.back().t - events.front().t).count());
  EXPECT_NEAR(static_cast<double>(samples.size()), physics.imu.rate_hz * seconds, 0.05 * physics.imu.rate_hz * seconds);
  EXPECT_NEAR(static_cast<double>((samples.front().t - events.front().t).count()), 0, 10'000);
  EXPECT_NEAR(static_cast<double>((samples.back().t - events.back().t).count()), 0, 10'000);
  for (std::size_t i = 1; i < samples.size(); ++i) ASSERT_LT(samples[i - 1].t, samples[i].t);
}

TEST(Simulate, NamesRunsOfOneSessionAlikeAndOnlyThese) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.runs = 2;
  const auto session = [&](const std::string& object, const std::string& run) {
    return draw_run(default_physics(), object, run, "tiny", 1).clocks.session;
  };
  std::map<bool, std::string> object_by_shared;
  for (const ObjectModel& object : default_physics().objects)
    object_by_shared[session(object.name, "01") == session(object.name, "02")] = object.name;
  ASSERT_EQ(object_by_shared.size(), 2U) << "some objects have a session for all of their runs, some one for each";
  options.objects = {object_by_shared[false], object_by_shared[true]};
  simulate(options);
  for (const auto& [shared, object] : object_by_shared) {
    const RunFolder one = run_folder_at(folder / object / "01"), two = run_folder_at(folder / object / "02");
    EXPECT_EQ(read_run_info(one).session, session(object, "01"));
    EXPECT_EQ(read_run_info(one).session == read_run_info(two).session, shared);
    const Truth first = read_truth(one.truth()), second = read_truth(two.truth());
    EXPECT_EQ(first.robot_clock->drift_ppm == second.robot_clock->drift_ppm, shared);
    if (!shared) continue;
    const std::int64_t stamp = second.robot_clock->reference_us;
    EXPECT_NEAR(static_cast<double>((first.robot_clock->camera_from(stamp) - second.robot_clock->camera_from(stamp)).count()), 0,
                2);
    EXPECT_GT(test::events_in_file(two.events()).front().t, test::events_in_file(one.events()).back().t);
  }
}

TEST(Simulate, TakesOtherPhysicsForOtherSettings) {
  const test::TemporaryFolder folder;
  write_whole(folder / "soft.json", R"({"objects": [{"name": "cup", "compliance": 0.5}, {"name": "fan", "depth_mm": 1.3}]})");
  SimulateOptions options = small(folder / "data");
  options.objects = {"fan", "usb-hub"};
  simulate(options);
  options.physics = read_physics(folder / "soft.json");
  options.objects = {"usb-hub"};
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::kept}) << "nothing that concerns it has changed";
  options.objects = {"fan"};
  EXPECT_THROW(simulate(options), Error) << "made with another fan";
  options.objects = {"cup"};
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::made});
  const RunInfo info = read_run_info(run_folder_at(folder / "data" / "cup" / "01"));
  EXPECT_EQ(info.extra.at("simulation").at("physics").at("source"), "soft.json");
  EXPECT_EQ(info.extra.at("simulation").at("physics").at("hash"), hash_of(json_of(options.physics)));
  EXPECT_EQ(info.extra.at("simulation").at("model_version"), 3);
}

TEST(Simulate, WritesAFilmWhoseFramesHaveTheirTrueTimes) {
  const test::TemporaryFolder folder;
  simulate(small(folder.path()));
  const RunFolder run = find_runs(folder.path()).at(0);
  const std::vector<VideoTime> times = video::read_video_times(run.video_times());
  ASSERT_GT(times.size(), 60U);
  cv::VideoCapture film(run.video().string(), cv::CAP_FFMPEG);
  ASSERT_TRUE(film.isOpened());
  cv::Mat frame, before;
  for (std::size_t i = 0; i < times.size(); ++i) {
    ASSERT_TRUE(film.read(frame));
    EXPECT_NEAR(1000.0 * film.get(cv::CAP_PROP_POS_MSEC), static_cast<double>(us_of(times[i])), 0.5);
    EXPECT_EQ(frame.size(), cv::Size(320, 240));
    if (i > 0) {
      EXPECT_GT(cv::norm(frame, before, cv::NORM_L1) / (3.0 * 320 * 240), 0.05) << i << ": its noise outlives the compression";
    }
    frame.copyTo(before);
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
  fs::resize_file(first / "robot.csv", fs::file_size(first / "robot.csv") / 2);
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::replaced}) << "and one whose file was cut";
  EXPECT_EQ(kinds(simulate(options)), std::vector{Kind::kept});
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

/// Calls `action` once, when a simulation is half done.
ProgressCallback half_way(const std::function<void()>& action) {
  return [action, done = false](const Progress& progress) mutable {
    if (done || 2 * progress.done <= progress.total) return;
    done = true;
    action();
  };
}

TEST(Simulate, TouchesNothingWhereAnotherWritesTheSameFolder) {
  const test::TemporaryFolder folder;
  SimulateOptions options = small(folder.path());
  options.runs = 2;
  const auto first = half_way([&] {
    SimulateOptions other = options;
    for (const bool force : {false, true}) {
      for (const std::uint64_t seed : {1U, 2U}) {
        other.force = force;
        other.seed = seed;
        const auto before = contents(folder.path());
        EXPECT_EQ(test::error_of([&] { simulate(other); }),
                  folder.path().string() +
                      ": another 'tactile simulate' is writing to this folder; wait until it has ended, or use another folder");
        EXPECT_EQ(contents(folder.path()), before) << force << seed;
      }
    }
    EXPECT_EQ(kinds(simulate(small(folder / "other"))), std::vector{Kind::made}) << "another folder is free";
  });
  EXPECT_EQ(kinds(simulate(options, first)), (std::vector{Kind::made, Kind::made}));
  EXPECT_EQ(kinds(simulate(options)), (std::vector{Kind::kept, Kind::kept})) << "both are of the first";
}

TEST(Simulate, KeepsARunThatAppearsMeanwhile) {
  const test::TemporaryFolder folder;
  SimulateOptions forced = small(folder.path());
  forced.force = true;
  const fs::path run = folder / "uhu-glue-stick/01";
  EXPECT_THROW(simulate(forced, half_way([&] { write_whole(run / "events.aedat4", "a real recording"); })), Error);
  EXPECT_EQ(read_text(run / "events.aedat4"), "a real recording");
}

TEST(Simulate, ResumesWhatAKilledOneLeftAndRemovesItsParts) {
  const test::TemporaryFolder folder;
  std::array<int, 2> half_done{};
  ASSERT_EQ(::pipe(half_done.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    simulate(small(folder.path()), half_way([&] {
               ::close(half_done[1]);
               ::pause();
             }));
    ::_exit(1);
  }
  ::close(half_done[1]);
  char nothing = 0;
  ASSERT_EQ(::read(half_done[0], &nothing, 1), 0) << "the child has closed its end";
  ::close(half_done[0]);
  SimulateOptions options = small(folder.path());
  options.objects = {"fan"};
  EXPECT_THROW(simulate(options), Error) << "while it lives";
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_FALSE(contents(folder.path()).empty());
  simulate(options);
  for (const auto& [name, text] : contents(folder.path())) EXPECT_TRUE(name.starts_with("fan/01/")) << name;
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
}  // namespace tactile::simulation
