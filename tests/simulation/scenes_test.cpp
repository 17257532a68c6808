// The scenes of configs/scenes: each is made once and read back, and keeps what its name promises.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/simulate.hpp"
#include "tactile/simulation/simulated_run.hpp"

namespace tactile::simulation {
namespace {

namespace fs = std::filesystem;

const fs::path scenes = fs::path(test::data_folder).parent_path().parent_path() / "configs" / "scenes";

/// A run of a scene, and how many events each of its read-outs has.
struct MadeScene {
  test::TemporaryFolder folder;
  SimulationPhysics physics;
  SimulatedRun made;
  RunFolder run;
  Truth truth;
  events::SensorSize size;
  std::map<CameraTime, std::size_t> readouts;
  double duration_s = 0;

  explicit MadeScene(const std::string& name) : physics(read_physics(scenes / (name + ".json"))) {
    made = simulate({.data = folder.path(), .objects = {"sprayer"}, .threads = 1, .physics = physics}).at(0);
    run = find_runs(folder.path()).at(0);
    truth = read_truth(run.truth());
    events::RecordingReader recording(run.events());
    const events::Stream& stream = events::event_stream(recording);
    size = stream.size.value();
    events::for_all_events(recording, stream.id, [&](std::span<const events::Event> events) {
      for (const events::Event& event : events) ++readouts[event.t];
    });
    EXPECT_EQ(recording.problems().broken_packets + recording.problems().out_of_range_events, 0U);
    EXPECT_EQ(count(CameraTime::min(), CameraTime::max()), made.events);
    EXPECT_EQ(made.kind, SimulatedRun::Kind::made);
  }

  std::uint64_t count(CameraTime begin, CameraTime end) const {
    std::uint64_t events = 0;
    for (auto at = readouts.lower_bound(begin); at != readouts.end() && at->first < end; ++at) events += at->second;
    return events;
  }
  /// [1/s]
  double rate(CameraTime begin, CameraTime end) const {
    return static_cast<double>(count(begin, end)) / (1e-6 * static_cast<double>((end - begin).count()));
  }
  CameraTime start() const { return camera_time(truth.parameters.at("camera_start_us").get<std::int64_t>()); }
  std::vector<TrueInterval> all(const std::string& what) const {
    std::vector<TrueInterval> found;
    std::copy_if(truth.intervals.begin(), truth.intervals.end(), std::back_inserter(found),
                 [&](const TrueInterval& interval) { return interval.what == what; });
    return found;
  }
};

TEST(Scenes, AreAllTestedAndDescribed) {
  std::set<std::string> names;
  for (const fs::directory_entry& file : fs::directory_iterator(scenes)) {
    names.insert(file.path().stem().string());
    EXPECT_TRUE(read_json(file.path()).contains("why")) << file.path();
    EXPECT_NO_THROW(read_physics(file.path())) << file.path();
  }
  EXPECT_EQ(names, (std::set<std::string>{"blinding-flicker", "dead-quiet", "easy", "hard", "plain", "saturated-readout",
                                          "small-camera", "sync-taps", "twenty-million"}));
}

/// By what factor the depths of the runs of an object differ: the deepest over the flattest, the largest of all objects.
double depth_ratio(const SimulationPhysics& physics) {
  double ratio = 1;
  for (const ObjectModel& object : physics.objects) {
    double least = 10, most = 0;
    for (const char* run : {"01", "02", "03"}) {
      const double depth_mm = draw_run(physics, object.name, run, "tiny", 1).plan.presses[0].depth_mm;
      least = std::min(least, depth_mm);
      most = std::max(most, depth_mm);
    }
    ratio = std::max(ratio, most / least);
  }
  return ratio;
}

TEST(Scenes, HardHasRunsThatDifferAndEasyHasRunsThatAreAlike) {
  const MadeScene hard("hard"), easy("easy");
  for (const MadeScene* scene : {&hard, &easy}) {
    EXPECT_EQ(scene->all("press").size(), 1U);
    EXPECT_EQ(scene->all("slip").size(), 1U);
  }
  const double usual = depth_ratio(default_physics());
  EXPECT_GT(depth_ratio(hard.physics), 1.5);
  EXPECT_LT(usual, 1.2);
  EXPECT_LT(depth_ratio(easy.physics), usual);
  EXPECT_LT(easy.rate(easy.start(), easy.start() + 500ms), 0.5 * hard.rate(hard.start(), hard.start() + 500ms))
      << "its camera is quiet";
  EXPECT_TRUE(easy.all("micro-slip").empty() && easy.all("turn").empty());
}

TEST(Scenes, OfTheStudyBeyondTheRangesCanBeDrawn) {
  int files = 0;
  for (const fs::directory_entry& file :
       fs::directory_iterator(scenes.parent_path().parent_path() / "studies" / "out-of-range")) {
    SCOPED_TRACE(file.path());
    const SimulationPhysics physics = read_physics(file.path());
    EXPECT_TRUE(read_json(file.path()).contains("why"));
    EXPECT_NE(json_of(physics), json_of(default_physics()));
    EXPECT_NO_THROW(draw_run(physics, "fan", "01", "quick", 1));
    ++files;
  }
  EXPECT_GT(files, 0);
}

TEST(Scenes, SaturatedReadoutNeverGivesMoreThanItsLimitAndOftenGivesIt) {
  const MadeScene scene("saturated-readout");
  const auto limit = static_cast<std::size_t>(scene.physics.camera.readout_limit);
  std::size_t full = 0;
  for (const auto& [t, events] : scene.readouts) {
    ASSERT_LE(events, limit);
    full += events == limit ? 1 : 0;
  }
  EXPECT_GT(full, 500U) << "a tenth of a second of read-outs";
}

TEST(Scenes, BlindingFlickerDrownsTheTouch) {
  const MadeScene scene("blinding-flicker");
  const double pixels = scene.size.width * scene.size.height;
  const TouchInterval press = scene.all("press").at(0).interval;
  const double quiet = scene.rate(scene.start(), press.start);
  EXPECT_GT(quiet, 100.0 * pixels) << "every pixel more than a hundred times a second";
  EXPECT_LT(scene.rate(press.start, press.end), 1.1 * quiet);
}

TEST(Scenes, DeadQuietHasNoEventAtAll) {
  const MadeScene scene("dead-quiet");
  EXPECT_EQ(scene.made.events, 0U);
  EXPECT_GT(scene.made.duration_s, 3.0);
  EXPECT_EQ(scene.all("press").size(), 1U) << "the skin moves, but invisibly";
  EXPECT_EQ(scene.all("press").at(0).first_event, std::nullopt);
}

TEST(Scenes, TwentyMillionIsAsManyEventsASecond) {
  const MadeScene scene("twenty-million");
  EXPECT_NEAR(static_cast<double>(scene.made.events) / scene.made.duration_s, 20e6, 2e6);
  EXPECT_LT(scene.made.duration_s, 1.0);
}

TEST(Scenes, SmallCameraSeesTheTouchIn320By240Pixels) {
  const MadeScene scene("small-camera");
  EXPECT_EQ(scene.size, (events::SensorSize{320, 240}));
  EXPECT_EQ(read_run_info(scene.run).width, 320);
  const TouchInterval press = scene.all("press").at(0).interval;
  EXPECT_GT(scene.rate(press.start, press.end), 1.2 * scene.rate(scene.start(), press.start));
}

TEST(Scenes, SyncTapsAreSeenByCameraAndRobotAtBothEnds) {
  const MadeScene scene("sync-taps");
  const std::vector<TrueInterval> taps = scene.all("tap");
  ASSERT_EQ(taps.size(), 6U);
  const TouchInterval press = scene.all("press").at(0).interval, slip = scene.all("slip").at(0).interval;
  EXPECT_LT(taps[2].interval.end, press.start);
  EXPECT_LT(slip.end, taps[3].interval.start);
  const double quiet = scene.rate(scene.start(), scene.start() + 500ms);
  const robot::RobotLog robot = robot::read_robot_log(scene.run.robot()).longest();
  for (const TrueInterval& tap : taps) {
    EXPECT_FALSE(tap.labelled);
    EXPECT_GT(scene.rate(tap.interval.start, tap.interval.end), 1.15 * quiet);
    const bool moved = std::any_of(robot.states.begin(), robot.states.end(), [&](const robot::RobotState& state) {
      const CameraTime t = scene.truth.robot_clock->camera_from(state.t);
      return tap.interval.start - 100ms < t && t < tap.interval.start && state.tcp_speed[2] < -0.005;
    });
    EXPECT_TRUE(moved) << "the arm goes down before the skin is touched";
  }
}

}  // namespace
}  // namespace tactile::simulation
