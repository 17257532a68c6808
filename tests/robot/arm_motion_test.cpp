#include "tactile/robot/arm_motion.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "robot/made_arm.hpp"

namespace tactile {
namespace {

using test::MadeArm;

double start_error_ms(const CommandedMotion& motion, double start_s) {
  return 1e-3 * static_cast<double>(us_of(motion.start())) - 1e3 * start_s;
}

RobotState state_at(std::int64_t us, double vx) {
  RobotState state;
  state.t = RobotTime{microseconds{us}};
  state.tcp_speed[0] = vx;
  return state;
}

TEST(ArmMotion, LiesOnStraightLinesBetweenTheRows) {
  RobotLog log;
  log.states = {state_at(1'000'000, 0.0), state_at(1'008'000, 0.08), state_at(1'016'000, 0.08)};
  const auto motion = arm_motion(log, {.step = 4ms});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->velocity.size(), 5U);
  EXPECT_NEAR(motion->velocity[1][0], 0.04, 1e-12);
  EXPECT_NEAR(motion->velocity[2][0], 0.08, 1e-12);
  EXPECT_NEAR(motion->acceleration[0][0], 10.0, 1e-9);
  EXPECT_NEAR(motion->acceleration[3][0], 0.0, 1e-9);
  EXPECT_EQ(us_of(motion->time_of(4)), 1'016'000);
}

TEST(ArmMotion, KnowsNothingWithinAGap) {
  RobotLog log;
  log.states = {state_at(0, 0.1), state_at(8'000, 0.1), state_at(208'000, 0.1), state_at(216'000, 0.1)};
  const auto motion = arm_motion(log, {.step = 4ms});
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->known[1]);
  EXPECT_FALSE(motion->known[20]);
  EXPECT_EQ(motion->velocity[20][0], 0.0);
  EXPECT_TRUE(motion->known[53]);
}

TEST(ArmMotion, IsNotMadeOfALogThatWouldNeedTooManyPoints) {
  RobotLog log;
  log.states = {state_at(std::numeric_limits<std::int64_t>::min(), 0), state_at(std::numeric_limits<std::int64_t>::max(), 0)};
  EXPECT_FALSE(arm_motion(log));
  EXPECT_FALSE(arm_motion(RobotLog{}));
}

TEST(CommandedMotions, FindALiftsStartThroughItsRinging) {
  for (const double share : {0.0, 0.2, 0.45}) {
    for (const double hz : {13.0, 19.0, 27.0}) {
      MadeArm arm;
      arm.ringing_share = share;
      arm.ringing_hz = hz;
      arm.lift(1.2345, 0.7, 0.08);
      const auto motions = commanded_motions(arm.log(0, 3));
      ASSERT_EQ(motions.size(), 1U);
      EXPECT_EQ(motions[0].kind, CommandedMotion::Kind::one_way);
      EXPECT_NEAR(start_error_ms(motions[0], 1.2345), 0.0, 1.2) << share << " at " << hz << " Hz";
      EXPECT_NEAR(1e-6 * static_cast<double>(us_of(motions[0].end())), 1.9345, 1.5e-3);
      EXPECT_NEAR(motions[0].direction[2], 1.0, 0.01);
      EXPECT_NEAR(motions[0].told_m_s(motions[0].change_s[1] + 0.1), 0.08, 0.002);
      EXPECT_LT(motions[0].sigma_s, 1e-3);
    }
  }
}

TEST(CommandedMotions, FindThemAtFiveHundredRowsASecond) {
  MadeArm arm;
  arm.ringing_share = 0.3;
  arm.lift(1.0, 0.6, 0.05);
  const auto motions = commanded_motions(arm.log(0, 3, 0, 0, 0.002));
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_NEAR(start_error_ms(motions[0], 1.0), 0.0, 0.6);
}

TEST(CommandedMotions, TellTapsAndTheirLowestPoint) {
  MadeArm arm;
  arm.ringing_share = 0.25;
  arm.tap(0.8, 0.25, 0.003);
  arm.tap(1.5, 0.21, 0.002);
  arm.lift(2.6, 0.6, 0.06);
  const auto motions = commanded_motions(arm.log(0, 4));
  ASSERT_EQ(motions.size(), 3U);
  EXPECT_EQ(motions[0].kind, CommandedMotion::Kind::there_and_back);
  EXPECT_EQ(motions[1].kind, CommandedMotion::Kind::there_and_back);
  EXPECT_EQ(motions[2].kind, CommandedMotion::Kind::one_way);
  EXPECT_NEAR(1e-6 * static_cast<double>(us_of(motions[0].time_at(motions[0].turn_s()))), 0.925, 8e-4);
  EXPECT_NEAR(1e-6 * static_cast<double>(us_of(motions[1].time_at(motions[1].turn_s()))), 1.605, 8e-4);
  EXPECT_LT(motions[0].direction[2], -0.99) << "it goes down first";
}

TEST(CommandedMotions, LeaveOutWhatIsNotWhole) {
  MadeArm arm;
  arm.lift(1.0, 0.6, 0.06);
  EXPECT_TRUE(commanded_motions(arm.log(1.2, 3)).empty()) << "under way when the log begins";
  EXPECT_TRUE(commanded_motions(arm.log(0, 1.4)).empty()) << "under way when the log ends";
  RobotLog log = arm.log(0, 3);
  std::erase_if(log.states, [](const RobotState& state) { return us_of(state.t) > 1'200'000 && us_of(state.t) < 1'350'000; });
  EXPECT_TRUE(commanded_motions(log).empty()) << "a gap in the middle";
  EXPECT_TRUE(commanded_motions(MadeArm{}.log(0, 3)).empty()) << "nothing but noise";
  EXPECT_TRUE(commanded_motions(RobotLog{}).empty());
}

TEST(CommandedMotions, HoldNearTheEndsOfTime) {
  MadeArm arm;
  arm.lift(1.0, 0.6, 0.06);
  const std::int64_t zero = std::numeric_limits<std::int64_t>::max() - 5'000'000;
  const auto motions = commanded_motions(arm.log(0, 3, zero));
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_NEAR(static_cast<double>(us_of(motions[0].start()) - zero), 1e6, 1'200);
}

}  // namespace
}  // namespace tactile
