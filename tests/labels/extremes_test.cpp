// Runs as labs have them at their worst: each is simulated, its files are altered, and its labels are held against the truth.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>

#include "labels/altered_run.hpp"
#include "support/error_of.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

using test::AlteredRun;
using test::expect_as_true;
using test::expect_lift_as_true;
using test::flags_say;
using test::only_runs;
using test::plain_physics;
using test::remarks_say;
using test::told_by;

std::uint64_t SEED() { const char* s = std::getenv("SEED"); return s ? std::stoull(s) : 1; }
std::string OBJECT() { const char* s = std::getenv("OBJECT"); return s ? s : "fan"; }
struct Tell {
  explicit Tell(const Labels& l) { if (std::getenv("TELL")) std::printf("%s", told_by(l).c_str()); }
};

const fs::path scenes = fs::path(TACTILE_TEST_DATA).parent_path().parent_path() / "configs" / "scenes";

AlteredRun scene(const std::string& name, const std::string& preset = "quick") {
  return AlteredRun(read_physics(scenes / (name + ".json")), "sprayer", SEED(), preset);
}

std::size_t count(const Labels& labels, Touch touch) {
  return static_cast<std::size_t>(
      std::count_if(labels.intervals.begin(), labels.intervals.end(), [&](const auto& i) { return i.touch == touch; }));
}

TEST(Extremes, PlainRunForComparison) {
  const AlteredRun made(plain_physics(), OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(labels.flags.empty()) << told_by(labels);
}

TEST(Extremes, WithoutSlipThereIsNoneAndThePressIsRight) {
  const AlteredRun made(only_runs(&SpecialRuns::without_slip), OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  EXPECT_EQ(count(labels, Touch::slip), 0U);
}

TEST(Extremes, WithoutPressThereIsNoneAndTheSlipIsRight) {
  const AlteredRun made(only_runs(&SpecialRuns::without_press), OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  EXPECT_EQ(count(labels, Touch::press), 0U);
}

TEST(Extremes, OfNoiseAloneFindsNothingAndSaysSo) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  // What the first half second has, over and over, with the hot pixels that it has.
  const CameraTime until = after(made.truly("press").start, -100ms);
  made.alter_recording([&](std::vector<Event>& events, std::vector<ImuSample>&) {
    const CameraTime first = events.front().t;
    const CameraTime last = events.back().t;
    std::erase_if(events, [&](const Event& event) { return event.t >= until; });
    const std::vector<Event> quiet = events;
    for (microseconds later = until - first; first + later <= last; later += until - first) {
      for (Event event : quiet) {
        event.t += later;
        events.push_back(event);
      }
    }
  });
  const Labels labels = made.labels(); Tell t(labels);
  EXPECT_TRUE(labels.intervals.empty()) << told_by(labels);
  EXPECT_TRUE(flags_say(labels, "no press found")) << told_by(labels);
  EXPECT_TRUE(flags_say(labels, "no slip found") || flags_say(labels, "without a slip")) << told_by(labels);
}

TEST(Extremes, OfTwoPressesTheReleaseBetweenIsNoPress) {
  const AlteredRun made(only_runs(&SpecialRuns::two_presses), OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  made.truly("release");
  EXPECT_EQ(count(labels, Touch::press), 2U) << told_by(labels);
  expect_as_true(labels, made.truth);
}

TEST(Extremes, AHotPixelThatStartsDuringTheRunIsNoTouch) {
  for (const std::string when : {"before the press", "within the press", "after it", "after the slip"}) {
    AlteredRun made(plain_physics(), OBJECT(), SEED());
    const TouchInterval press = made.truly("press"), slip = made.truly("slip");
    const CameraTime from = when == "before the press"   ? after(press.start, -200ms)
                            : when == "within the press" ? after(press.start, 50ms)
                            : when == "after it"         ? after(press.end, 120ms)
                                                         : after(slip.end, 200ms);
    made.alter_recording([&](std::vector<Event>& events, std::vector<ImuSample>&) {
      std::vector<Event> hot;
      for (CameraTime t = from; t < events.back().t; t += 200us) {
        Event event;
        event.t = t;
        event.x = 333;
        event.y = 77;
        event.on = 1;
        hot.push_back(event);
      }
      std::vector<Event> all;
      std::merge(events.begin(), events.end(), hot.begin(), hot.end(), std::back_inserter(all),
                 [](const Event& a, const Event& b) { return a.t < b.t; });
      events = all;
    });
    SCOPED_TRACE(when);
    const Labels labels = made.labels(); if (std::getenv("TELL")) std::printf("--- %s", when.c_str()); Tell t(labels);
    expect_as_true(labels, made.truth);
  }
}

TEST(Extremes, ARobotLogThatEndsWithinTheLift) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const RobotTime last = made.in_robot_time(after(*made.truth.lift_start, 250ms));
  made.alter_robot([&](std::vector<RobotState>& states) { std::erase_if(states, [&](const auto& s) { return s.t > last; }); });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  if (labels.robot_clocks.empty()) {
    EXPECT_TRUE(labels.run_is_flagged()) << told_by(labels);
  } else {
    expect_lift_as_true(labels, made);
  }
}

TEST(Extremes, ARobotLogThatBeginsAfterThePress) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const RobotTime first = made.in_robot_time(after(made.truly("press").end, 50ms));
  made.alter_robot([&](std::vector<RobotState>& states) { std::erase_if(states, [&](const auto& s) { return s.t < first; }); });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
}

TEST(Extremes, ARobotClockThatStartsAnewBeforeTheLift) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const RobotTime reset = made.in_robot_time(after(*made.truth.lift_start, -150ms));
  std::int64_t back = 0;
  made.alter_robot([&](std::vector<RobotState>& states) {
    back = us_of(reset) - 12'000'000;  // it is up for twelve seconds
    for (RobotState& s : states) if (s.t >= reset) s.t -= microseconds{back};
  });
  made.truth.robot_clock->offset_us = made.truth.robot_clock->camera_from(reset).time_since_epoch().count() - 12'000'000;
  made.truth.robot_clock->reference_us = 12'000'000;
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(flags_say(labels, "the robot's clock starts anew 1 times within its log")) << told_by(labels);
}

TEST(Extremes, ARobotClockThatStartsAnewAfterTheLift) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const RobotTime reset = made.in_robot_time(after(made.truly("slip").end, 200ms));
  made.alter_robot([&](std::vector<RobotState>& states) {
    for (RobotState& s : states) if (s.t >= reset) s.t -= microseconds{us_of(reset) - 12'000'000};
  });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(flags_say(labels, "the robot's clock starts anew 1 times within its log")) << told_by(labels);
}

TEST(Extremes, BothPiecesOfARobotsClockAreRelatedWhereEachHasALift) {
  // With an inertial sensor, or taps: each piece has motion.
  SimulationPhysics physics = only_runs(&SpecialRuns::taps);
  physics.imu.share = 1;
  AlteredRun made(physics, OBJECT(), SEED());
  const RobotTime reset = made.in_robot_time(after(*made.truth.lift_start, -150ms));
  const ClockRelation earlier = *made.truth.robot_clock;
  made.alter_robot([&](std::vector<RobotState>& states) {
    for (RobotState& s : states) if (s.t >= reset) s.t -= microseconds{us_of(reset) - 12'000'000};
  });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  ASSERT_EQ(labels.robot_clocks.size(), 2U) << told_by(labels);
  write_labels(made.run.labels(), labels);
  EXPECT_EQ(read_labels(made.run.labels()).robot_clocks.size(), 2U);
  const CameraTime seam = earlier.camera_from(reset);
  std::printf("  piece 0 off %ld, piece 1 off %ld\n", (long)(us_of(labels.robot_clocks[0].relation.camera_from(us_of(reset))) - us_of(seam)),
    (long)(us_of(labels.robot_clocks[1].relation.camera_from(12'000'000)) - us_of(seam)));
}

TEST(Extremes, ARobotLogOf500Hz) {
  SimulationPhysics physics = plain_physics();
  physics.robot.rate_hz = 500;
  const AlteredRun made(physics, OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(labels.flags.empty()) << told_by(labels);
}

TEST(Extremes, AFilmOfVariableRate) {
  SimulationPhysics physics = plain_physics();
  physics.video.jitter_ms = 8;
  physics.video.lost_frame_share = 0.25;
  const AlteredRun made(physics, OBJECT(), SEED());
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  const TruthComparison compared = compare_with_truth(labels, made.truth);
  if (compared.video_clock) {
    std::printf("  video error %ld width %ld %d\n", (long)compared.video_clock->error.count(), (long)compared.video_clock->width.count(), compared.video_clock->covered);
    EXPECT_TRUE(compared.video_clock->covered) << compared.video_clock->error.count() << " us" << told_by(labels);
  } else {
    EXPECT_TRUE(remarks_say(labels, "the film's clock is not related")) << told_by(labels);
  }
}

TEST(Extremes, AFilmThatIsCutInItsMiddle) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  fs::resize_file(made.run.video(), fs::file_size(made.run.video()) / 2);
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
}

TEST(Extremes, AGapInQuietTime) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const CameraTime press = made.truly("press").start;
  made.alter_recording([&](std::vector<Event>& events, std::vector<ImuSample>&) {
    std::erase_if(events, [&](const Event& e) { return e.t > after(press, -350ms) && e.t < after(press, -250ms); });
  });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(flags_say(labels, "the recording has a gap: no pixel fires for ")) << told_by(labels);
}

TEST(Extremes, AGapAcrossTheSlipsOnset) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  const CameraTime slip = made.truly("slip").start;
  made.alter_recording([&](std::vector<Event>& events, std::vector<ImuSample>&) {
    std::erase_if(events, [&](const Event& e) { return e.t > after(slip, -40ms) && e.t < after(slip, 60ms); });
  });
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(flags_say(labels, "the recording has a gap: no pixel fires for ")) << told_by(labels);
}

TEST(Extremes, EventsAtTheEndsOfInt64) {
  for (const bool high : {true, false}) {
    SimulationPhysics physics = plain_physics();
    physics.imu.share = 1;
    AlteredRun made(physics, OBJECT(), SEED());
    std::int64_t shift = 0;
    made.alter_recording([&](std::vector<Event>& events, std::vector<ImuSample>& imu) {
      const std::int64_t first = std::min(us_of(events.front().t), us_of(imu.front().t)),
                         last = std::max(us_of(events.back().t), us_of(imu.back().t));
      shift = high ? std::numeric_limits<std::int64_t>::max() - 1 - last : std::numeric_limits<std::int64_t>::min() + 1 - first;
      for (Event& e : events) e.t += microseconds{shift};
      for (ImuSample& s : imu) s.t += microseconds{shift};
    });
    for (TrueInterval& i : made.truth.intervals) {
      if (!i.labelled) continue;
      i.interval.start += microseconds{shift};
      i.interval.end += microseconds{shift};
      i.first_event.reset();
      i.gross.reset();
    }
    made.truth.robot_clock.reset();
    made.truth.video_clock.reset();
    made.truth.lift_start.reset();
    SCOPED_TRACE(high ? "2^63" : "-2^63");
    const Labels labels = made.labels(); Tell t(labels);
    expect_as_true(labels, made.truth);
    write_labels(made.run.labels(), labels);
    EXPECT_EQ(read_labels(made.run.labels()).intervals.size(), labels.intervals.size());
  }
}

TEST(Extremes, AnEmptyRobotLog) {
  for (const bool header : {true, false}) {
    AlteredRun made(plain_physics(), OBJECT(), SEED());
    fs::remove(made.run.robot());
    if (header) write_robot_log(made.run.robot(), {});
    else write_whole(made.run.robot(), "");
    const std::vector<RunOutcome> done = label_runs({made.run});
    Tell t(done[0].labels);
    std::printf("header %d error: %s\n", header, done[0].error.c_str());
    if (done[0].error.empty()) {
      expect_as_true(done[0].labels, made.truth);
      EXPECT_TRUE(done[0].labels.run_is_flagged()) << told_by(done[0].labels);
    }
  }
}

TEST(Extremes, WithoutRunJson) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  fs::remove(made.run.info());
  const std::vector<RunOutcome> done = label_runs({made.run});
  Tell t(done[0].labels);
  EXPECT_EQ(done[0].error, "");
  expect_as_true(done[0].labels, made.truth);
}

TEST(Extremes, TheTruthIsNotRead) {
  AlteredRun made(plain_physics(), OBJECT(), SEED());
  label_runs({made.run});
  const std::string first = read_text(made.run.labels());
  fs::remove(made.run.labels());
  fs::remove(made.run.truth());
  label_runs({made.run});
  EXPECT_EQ(read_text(made.run.labels()), first);
}

TEST(Extremes, SyncTapsAreNoPresses) {
  const AlteredRun made = scene("sync-taps", "tiny");
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
}

TEST(Extremes, SaturatedReadout) {
  const AlteredRun made = scene("saturated-readout");
  const Labels labels = made.labels(); Tell t(labels);
  expect_as_true(labels, made.truth);
}

TEST(Extremes, BlindingFlicker) {
  const AlteredRun made = scene("blinding-flicker");
  const Labels labels = made.labels(); Tell t(labels);
  const TruthComparison compared = compare_with_truth(labels, made.truth);
  EXPECT_TRUE(labels.run_is_flagged()) << told_by(labels);
}

TEST(Extremes, DeadQuietIsAnError) {
  const AlteredRun made = scene("dead-quiet");
  EXPECT_NE(test::error_of([&] { made.labels(); }).find("holds no event; expected a recording of a run"), std::string::npos);
}

}  // namespace
}  // namespace tactile
