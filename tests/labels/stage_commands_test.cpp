#include "tactile/labels/stage_commands.hpp"

#include <gtest/gtest.h>

#include "labels/made_interval.hpp"

namespace tactile::labels {
namespace {

using test::made_interval;

CameraTime at_ms(std::int64_t ms) { return camera_time(1000 * ms); }

/// A recording of 10 s with a robot log on the camera's clock, whose output changes at these times.
struct StageRun {
  alignment::RunSignals signals;
  RobotPieceClocks clocks;

  explicit StageRun(const std::vector<std::int64_t>& closes_ms) {
    signals.rate.begin = at_ms(0);
    signals.rate.last = at_ms(10'000);
    signals.robot.resize(1);
    for (const std::int64_t ms : closes_ms) {
      robot::OutputChange change{};
      change.at = change.last_before = RobotTime{microseconds{1000 * ms}};
      change.output = "digital output 0";
      change.to = 1;
      signals.robot[0].output_changes.push_back(change);
    }
    alignment::FittedClock clock;
    clock.offset_low_us = -10'000;
    clock.offset_high_us = 10'000;
    clocks.emplace_back(clock);
  }
};

TEST(CommandsWithoutPress, AreThoseThatNoPressFollows) {
  const StageRun run({1000, 4000});
  Labels labels;
  labels.intervals = {made_interval(Touch::press, 1300, 1500), made_interval(Touch::slip, 7000, 8000)};
  const std::vector<LabelFlag> flags = commands_without_press(run.signals, run.clocks, labels);
  ASSERT_EQ(flags.size(), 1U);
  EXPECT_FALSE(flags[0].interval_index);
  EXPECT_EQ(flags[0].reason, "the stage was commanded to close at 4.00 s, and no press is labelled in the 2 s after it");
  EXPECT_EQ(stage_command(run.signals, run.clocks, at_ms(1300)), at_ms(1000));

  labels.intervals.insert(labels.intervals.begin() + 1, made_interval(Touch::press, 4400, 4600));
  EXPECT_TRUE(commands_without_press(run.signals, run.clocks, labels).empty());
}

TEST(CommandsWithoutPress, AreNotKnownByAnOutputThatIsNoStages) {
  Labels labels;
  labels.intervals = {made_interval(Touch::press, 1300, 1500)};
  const StageRun lamp({4000, 5000}), late({1000, 9000});
  EXPECT_TRUE(commands_without_press(lamp.signals, lamp.clocks, labels).empty());
  EXPECT_TRUE(commands_without_press(late.signals, late.clocks, labels).empty()) << "the recording may end before that press";
  StageRun two({1000, 4000});
  two.signals.robot[0].output_changes[1].output = "digital output 1";
  EXPECT_TRUE(commands_without_press(two.signals, two.clocks, labels).empty());
  StageRun unrelated({1000, 4000});
  unrelated.clocks[0].reset();
  EXPECT_TRUE(commands_without_press(unrelated.signals, unrelated.clocks, labels).empty());
}

}  // namespace
}  // namespace tactile::labels
