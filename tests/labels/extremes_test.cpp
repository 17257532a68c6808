// Runs as labs have them at their worst: each is simulated, its files are altered, and its labels are held against the truth.

#include <gtest/gtest.h>

#include <iterator>
#include <limits>

#include "labels/altered_run.hpp"
#include "support/error_of.hpp"
#include "support/paths.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::labels {
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

const fs::path scenes = fs::path(test::data_folder).parent_path().parent_path() / "configs" / "scenes";

AlteredRun scene(const std::string& name, const std::string& preset = "quick") {
  return AlteredRun(simulation::read_physics(scenes / (name + ".json")), "sprayer", 1, preset);
}

std::size_t count(const Labels& labels, Touch touch) {
  return static_cast<std::size_t>(
      std::count_if(labels.intervals.begin(), labels.intervals.end(), [&](const auto& i) { return i.touch == touch; }));
}

TEST(Extremes, APlainRunIsRightAndUnflagged) {
  const AlteredRun made;
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(labels.flags.empty()) << told_by(labels);
}

/// Events all over the image, 300 per millisecond.
void add_burst(AlteredRun& made, CameraTime begin, microseconds lasts) {
  made.alter_recording([&](std::vector<events::Event>& events, auto&) {
    Random random(3);
    for (CameraTime t = begin; t < after(begin, lasts); t = after(t, 200us)) {
      for (int n = 0; n < 60; ++n) {
        events::Event event;
        event.t = t;
        event.x = static_cast<std::int16_t>(random.below(640));
        event.y = static_cast<std::int16_t>(random.below(480));
        event.on = static_cast<std::uint8_t>(random.below(2));
        events.push_back(event);
      }
    }
    std::stable_sort(events.begin(), events.end(), [](const events::Event& a, const events::Event& b) { return a.t < b.t; });
  });
}

TEST(Extremes, WithoutRobotLogTheSlipIsFoundAmongOtherBursts) {
  simulation::SimulationPhysics physics = plain_physics();
  physics.imu.share = 1;
  AlteredRun made(physics);
  add_burst(made, after(made.truly("slip").end, 400ms), 250ms);
  fs::remove(made.run.robot());
  const Labels labels = made.labels();
  ASSERT_EQ(count(labels, Touch::slip), 1U) << told_by(labels);
  const auto slip =
      std::find_if(labels.intervals.begin(), labels.intervals.end(), [](const auto& i) { return i.touch == Touch::slip; });
  EXPECT_LT(std::chrono::abs(between(made.truly("slip").start, slip->start.at)), 10ms) << told_by(labels);
}

TEST(Extremes, WithoutSlipThereIsNoneAndThePressIsRight) {
  const AlteredRun made(only_runs(&simulation::SpecialRuns::without_slip));
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_EQ(count(labels, Touch::slip), 0U);
}

TEST(Extremes, WithoutPressThereIsNoneAndTheSlipIsRight) {
  const AlteredRun made(only_runs(&simulation::SpecialRuns::without_press));
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_EQ(count(labels, Touch::press), 0U);
}

TEST(Extremes, OfNoiseAloneNothingIsSure) {
  AlteredRun made;
  // The pixels of the first half second, over and over, at other times.
  const CameraTime until = after(made.truly("press").start, -100ms);
  made.alter_recording([&](std::vector<events::Event>& events, std::vector<events::ImuSample>&) {
    Random random(7);
    const CameraTime first = events.front().t, last = events.back().t;
    std::erase_if(events, [&](const events::Event& event) { return event.t >= until; });
    const std::vector<events::Event> quiet = events;
    events.clear();
    const auto length = static_cast<std::uint64_t>(between(first, until).count());
    for (CameraTime begin = first; begin < last; begin = after(begin, until - first)) {
      for (events::Event event : quiet) {
        event.t = after(begin, microseconds{random.below(length)});
        if (event.t <= last) events.push_back(event);
      }
    }
    std::stable_sort(events.begin(), events.end(), [](const events::Event& a, const events::Event& b) { return a.t < b.t; });
  });
  const Labels labels = made.labels();
  // The arm lifts, and at 142 events/ms of noise a faint slip would not be seen.
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) EXPECT_TRUE(labels.interval_is_flagged(i)) << told_by(labels);
  EXPECT_TRUE(remarks_say(labels, "no press found")) << told_by(labels);
}

TEST(Extremes, OfTwoPressesTheReleaseBetweenIsNoPress) {
  simulation::SimulationPhysics physics = only_runs(&simulation::SpecialRuns::two_presses);
  // Noise, turns of the object and tips that return slowly hide where presses and slips begin.
  physics.camera = simulation::with_camera("quiet").camera;
  physics.sessions.vary = false;
  physics.after_effects.turn_chance = 0;
  physics.after_effects.hysteresis_share = {0, 0};
  const AlteredRun made(physics);
  const Labels labels = made.labels();
  EXPECT_NO_THROW(made.truly("release"));
  EXPECT_EQ(count(labels, Touch::press), 2U) << told_by(labels);
  expect_as_true(labels, made.truth);
}

TEST(Extremes, AHotPixelThatStartsDuringTheRunIsNoTouch) {
  for (const std::string when : {"before the press", "within the press", "after it", "after the slip"}) {
    AlteredRun made;
    const TouchInterval press = made.truly("press"), slip = made.truly("slip");
    const CameraTime from = when == "before the press"   ? after(press.start, -200ms)
                            : when == "within the press" ? after(press.start, 50ms)
                            : when == "after it"         ? after(press.end, 120ms)
                                                         : after(slip.end, 200ms);
    made.alter_recording([&](std::vector<events::Event>& events, std::vector<events::ImuSample>&) {
      std::vector<events::Event> hot;
      for (CameraTime t = from; t < events.back().t; t += 200us) {
        events::Event event;
        event.t = t;
        event.x = 333;
        event.y = 77;
        event.on = 1;
        hot.push_back(event);
      }
      std::vector<events::Event> all;
      std::merge(events.begin(), events.end(), hot.begin(), hot.end(), std::back_inserter(all),
                 [](const events::Event& a, const events::Event& b) { return a.t < b.t; });
      events = all;
    });
    SCOPED_TRACE(when);
    const Labels labels = made.labels();
    expect_as_true(labels, made.truth);
  }
}

TEST(Extremes, ARobotLogThatEndsWithinTheLiftDoesNoHarm) {
  AlteredRun made;
  const RobotTime last = made.in_robot_time(after(*made.truth.lift_start, 250ms));
  made.alter_robot(
      [&](std::vector<robot::RobotState>& states) { std::erase_if(states, [&](const auto& s) { return s.t > last; }); });
  expect_as_true(made.labels(), made.truth);
}

TEST(Extremes, ARobotLogThatEndsBeforeTheLiftDoesNotHideTheSlip) {
  AlteredRun made;
  const RobotTime last = made.in_robot_time(before(*made.truth.lift_start, 100ms));
  made.alter_robot(
      [&](std::vector<robot::RobotState>& states) { std::erase_if(states, [&](const auto& s) { return s.t > last; }); });
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(remarks_say(labels, "the arm does not move in its log")) << told_by(labels);
}

TEST(Extremes, ARobotLogThatBeginsAfterThePressStillShowsTheLift) {
  AlteredRun made;
  const RobotTime first = made.in_robot_time(after(made.truly("press").end, 50ms));
  made.alter_robot(
      [&](std::vector<robot::RobotState>& states) { std::erase_if(states, [&](const auto& s) { return s.t < first; }); });
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
}

/// A controller that starts again at `reset` counts from here: the power came back a while ago.
constexpr microseconds up_since = 12s;

/// @return the second piece's clock, in truth
ClockRelation start_anew(AlteredRun& made, RobotTime reset) {
  const CameraTime seam = made.truth.robot_clock->camera_from(reset);
  made.alter_robot([&](std::vector<robot::RobotState>& states) {
    for (robot::RobotState& state : states) {
      if (state.t >= reset) state.t = RobotTime{up_since + (state.t - reset)};
    }
  });
  return {.offset_us = us_of(seam) - up_since.count(),
          .drift_ppm = made.truth.robot_clock->drift_ppm,
          .reference_us = up_since.count()};
}

TEST(Extremes, ARobotsClockThatRestartsBeforeTheLift) {
  AlteredRun made;
  made.truth.robot_clock = start_anew(made, made.in_robot_time(before(*made.truth.lift_start, 150ms)));
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(flags_say(labels, "the robot's clock restarts 1 time within its log")) << told_by(labels);
}

TEST(Extremes, ARobotsClockThatRestartsAfterTheLift) {
  AlteredRun made;
  start_anew(made, made.in_robot_time(after(made.truly("slip").end, 200ms)));
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(flags_say(labels, "the robot's clock restarts 1 time within its log")) << told_by(labels);
}

TEST(Extremes, EachPieceOfARobotsClockIsRelatedWhereTheArmMovesInIt) {
  simulation::SimulationPhysics physics = only_runs(&simulation::SpecialRuns::taps);
  physics.imu.share = 1;
  AlteredRun made(physics);
  const RobotTime reset = made.in_robot_time(before(*made.truth.lift_start, 150ms));
  const CameraTime seam = made.truth.robot_clock->camera_from(reset);
  start_anew(made, reset);
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  ASSERT_EQ(labels.robot_clocks.size(), 2U) << told_by(labels);
  write_labels(made.run.labels(), labels);
  EXPECT_EQ(read_labels(made.run.labels()).robot_clocks.size(), 2U);
  const CameraTime here = labels.robot_clocks[0].relation.camera_from(reset),
                   there = labels.robot_clocks[1].relation.camera_from(RobotTime{up_since});
  EXPECT_LE(std::chrono::abs(here - seam), 10ms) << told_by(labels);
  EXPECT_LE(std::chrono::abs(there - seam), 10ms) << told_by(labels);
}

TEST(Extremes, ARobotLogOf500HzIsAsGood) {
  simulation::SimulationPhysics physics = plain_physics();
  physics.robot.rate_hz = 500;
  const AlteredRun made(physics);
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
  EXPECT_TRUE(labels.flags.empty()) << told_by(labels);
}

TEST(Extremes, AFilmOfVariableRateIsRelatedByItsFramesOwnTimes) {
  simulation::SimulationPhysics physics = plain_physics();
  physics.video.jitter_ms = 8;
  physics.video.lost_frame_share = 0.25;
  const AlteredRun made(physics);
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  const TruthComparison compared = compare_with_truth(labels, made.truth);
  if (compared.video_clock) {
    EXPECT_TRUE(compared.video_clock->covered) << compared.video_clock->error.count() << " us" << told_by(labels);
  } else {
    EXPECT_TRUE(remarks_say(labels, "the film's clock is not related")) << told_by(labels);
  }
}

TEST(Extremes, AFilmThatLacksItsSecondHalfIsFlagged) {
  AlteredRun made;
  fs::resize_file(made.run.video(), fs::file_size(made.run.video()) / 2);
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(flags_say(labels, "the film lacks ")) << told_by(labels);
  if (const auto clock = compare_with_truth(labels, made.truth).video_clock) {
    EXPECT_TRUE(clock->covered) << clock->error.count() << " us" << told_by(labels);
  }
}

TEST(Extremes, AGapInQuietTimeIsFlaggedAndDoesNoHarm) {
  AlteredRun made;
  const CameraTime press = made.truly("press").start;
  made.alter_recording([&](std::vector<events::Event>& events, std::vector<events::ImuSample>&) {
    std::erase_if(events, [&](const events::Event& e) { return e.t > after(press, -350ms) && e.t < after(press, -250ms); });
  });
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(flags_say(labels, "the recording has a gap: no pixel fires for ")) << told_by(labels);
}

TEST(Extremes, AnOnsetInAGapIsFlaggedAndItsIntervalHoldsTheGap) {
  AlteredRun made;
  const CameraTime slip = made.truly("slip").start;
  made.alter_recording([&](std::vector<events::Event>& events, std::vector<events::ImuSample>&) {
    std::erase_if(events, [&](const events::Event& e) { return e.t > after(slip, -40ms) && e.t < after(slip, 60ms); });
  });
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  EXPECT_TRUE(flags_say(labels, "the recording has a gap: no pixel fires for ")) << told_by(labels);
  ASSERT_EQ(count(labels, Touch::slip), 1U) << told_by(labels);
  const alignment::UncertainTime& onset = labels.intervals.back().start;
  EXPECT_GT(between(onset.low, onset.high), 50ms) << told_by(labels);
  EXPECT_LT(onset.low, slip);
  EXPECT_GT(onset.high, slip);
}

TEST(Extremes, EventsAtTheEndsOfInt64AreLabelledAsAnywhere) {
  for (const bool high : {true, false}) {
    simulation::SimulationPhysics physics = plain_physics();
    physics.imu.share = 1;
    AlteredRun made(physics);
    std::uint64_t shift = 0;  // may be more than int64 holds; the sum is not
    const auto move = [&shift](CameraTime& t) {
      t = camera_time(static_cast<std::int64_t>(static_cast<std::uint64_t>(us_of(t)) + shift));
    };
    made.alter_recording([&](std::vector<events::Event>& events, std::vector<events::ImuSample>& imu) {
      const std::int64_t first = std::min(us_of(events.front().t), us_of(imu.front().t)),
                         last = std::max(us_of(events.back().t), us_of(imu.back().t));
      shift = high ? static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() - 1) - static_cast<std::uint64_t>(last)
                   : static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::min() + 1) - static_cast<std::uint64_t>(first);
      for (events::Event& e : events) move(e.t);
      for (events::ImuSample& s : imu) move(s.t);
    });
    for (TrueInterval& i : made.truth.intervals) {
      if (!i.labelled) continue;
      move(i.interval.start);
      move(i.interval.end);
      i.first_event.reset();
      i.gross.reset();
    }
    made.truth.robot_clock.reset();
    made.truth.video_clock.reset();
    made.truth.lift_start.reset();
    SCOPED_TRACE(high ? "2^63" : "-2^63");
    const Labels labels = made.labels();
    expect_as_true(labels, made.truth);
    EXPECT_EQ(flags_say(labels, "the two clocks lie further apart than 64 bits of microseconds"), !high) << told_by(labels);
    write_labels(made.run.labels(), labels);
    EXPECT_EQ(read_labels(made.run.labels()).intervals.size(), labels.intervals.size());
  }
}

TEST(Extremes, AnEmptyRobotLogIsFlaggedOrRefused) {
  for (const bool header : {true, false}) {
    AlteredRun made;
    fs::remove(made.run.robot());
    if (header)
      robot::write_robot_log(made.run.robot(), {});
    else
      write_whole(made.run.robot(), "");
    const RunOutcome done = label_runs({made.run}).at(0);
    if (!header) {
      EXPECT_NE(done.error.find("is empty; expected a header row with RTDE's names"), std::string::npos) << done.error;
      continue;
    }
    EXPECT_EQ(done.error, "");
    expect_as_true(done.labels, made.truth);
    EXPECT_TRUE(flags_say(done.labels, "the robot log has no row")) << told_by(done.labels);
  }
}

TEST(Extremes, WithoutRunJsonIsLabelled) {
  AlteredRun made;
  fs::remove(made.run.info());
  const std::vector<RunOutcome> done = label_runs({made.run});

  EXPECT_EQ(done[0].error, "");
  expect_as_true(done[0].labels, made.truth);
}

TEST(Extremes, TheTruthIsNotRead) {
  AlteredRun made;
  label_runs({made.run});
  const std::string first = read_text(made.run.labels());
  fs::remove(made.run.labels());
  fs::remove(made.run.truth());
  label_runs({made.run});
  EXPECT_EQ(read_text(made.run.labels()), first);
}

TEST(Extremes, SyncTapsAreNoPresses) {
  const AlteredRun made = scene("sync-taps", "tiny");
  const Labels labels = made.labels();
  expect_as_true(labels, made.truth);
  expect_lift_as_true(labels, made);
}

TEST(Extremes, ASaturatedReadoutLeavesOnsetsNearlyTrue) {
  const AlteredRun made = scene("saturated-readout");
  const Labels labels = made.labels();
  const TruthComparison compared = compare_with_truth(labels, made.truth);
  EXPECT_TRUE(compared.spurious.empty()) << told_by(labels);
  for (const IntervalComparison& interval : compared.intervals) {
    ASSERT_TRUE(interval.start) << told_by(labels);
    EXPECT_LE(std::chrono::abs(interval.start->error), 20ms) << told_by(labels);
  }
  EXPECT_TRUE(flags_say(labels, "read-outs of the recording are full")) << told_by(labels);
}

TEST(Extremes, FlickerThatHidesEverythingIsFlagged) {
  const AlteredRun made = scene("blinding-flicker");
  const Labels labels = made.labels();
  EXPECT_TRUE(flags_say(labels, "the light flickers at 100 Hz: its events hide touches")) << told_by(labels);
}

TEST(Extremes, ARecordingWithoutEventsIsAnError) {
  const AlteredRun made = scene("dead-quiet");
  EXPECT_NE(test::error_of([&] { made.labels(); }).find("holds no event; expected a recording of a run"), std::string::npos);
}

}  // namespace
}  // namespace tactile::labels
