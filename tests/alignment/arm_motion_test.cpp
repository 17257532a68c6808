#include "tactile/alignment/arm_motion.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tactile::alignment {
namespace {

robot::RobotState state_at(std::int64_t us, double vx) {
  robot::RobotState state;
  state.t = RobotTime{microseconds{us}};
  state.tcp_speed[0] = vx;
  return state;
}

TEST(ArmMotion, LiesOnStraightLinesBetweenTheRows) {
  robot::RobotLog log;
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
  robot::RobotLog log;
  log.states = {state_at(0, 0.1), state_at(8'000, 0.1), state_at(208'000, 0.1), state_at(216'000, 0.1)};
  const auto motion = arm_motion(log, {.step = 4ms});
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->known[1]);
  EXPECT_FALSE(motion->known[20]);
  EXPECT_EQ(motion->velocity[20][0], 0.0);
  EXPECT_TRUE(motion->known[53]);
}

TEST(ArmMotion, IsNotMadeOfALogThatWouldNeedTooManyPoints) {
  robot::RobotLog log;
  log.states = {state_at(std::numeric_limits<std::int64_t>::min(), 0), state_at(std::numeric_limits<std::int64_t>::max(), 0)};
  EXPECT_FALSE(arm_motion(log));
  EXPECT_FALSE(arm_motion(robot::RobotLog{}));
}

}  // namespace
}  // namespace tactile::alignment
