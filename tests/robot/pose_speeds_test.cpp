#include "tactile/robot/pose_speeds.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tactile/core/random.hpp"

namespace tactile::robot {
namespace {

/// Rows at these milliseconds, in which the arm speeds up along z and turns about x at 0.4 rad/s.
std::vector<RobotState> speeding_up(const std::vector<int>& at_ms) {
  std::vector<RobotState> states;
  for (const int ms : at_ms) {
    const double s = 1e-3 * ms;
    RobotState state;
    state.t = RobotTime{microseconds{1000 * ms}};
    state.tcp_pose = {0.1, 0.2, 0.3 + 0.01 * s + 0.6 * s * s, 0.4 * s, 0, 0};
    states.push_back(state);
  }
  return states;
}

TEST(SpeedsFromPoses, AreExactAtAConstantAccelerationEvenNextToLostRows) {
  for (const std::vector<int>& at_ms :
       {std::vector<int>{0, 8, 16, 24, 32, 40, 48}, {0, 8, 24, 32, 56, 64}, {0, 2, 4, 6, 10, 12, 14, 16, 20}}) {
    std::vector<RobotState> states = speeding_up(at_ms);
    set_speeds_from_poses(states);
    for (std::size_t i = 1; i + 1 < states.size(); ++i) {
      const double s = 1e-3 * at_ms[i];
      EXPECT_NEAR(states[i].tcp_speed[2], 0.01 + 1.2 * s, 1e-9) << at_ms[i] << " ms";
      EXPECT_NEAR(states[i].tcp_speed[3], 0.4, 1e-9);
      EXPECT_NEAR(states[i].tcp_speed[0], 0, 1e-12);
    }
  }
}

TEST(SpeedsFromPoses, DoNotReachOverAGap) {
  std::vector<RobotState> states = speeding_up({0, 8, 16, 400, 408, 416});
  for (std::size_t i = 3; i < 6; ++i) states[i].tcp_pose[0] += 5;
  set_speeds_from_poses(states);
  for (const RobotState& state : states) EXPECT_NEAR(state.tcp_speed[0], 0, 1e-9);
  EXPECT_NEAR(states[2].tcp_speed[2], 0.01 + 1.2 * 0.012, 1e-9) << "the line through the last two";
}

TEST(SpeedsFromPoses, OfOneRowOrTwoAreTheirDifference) {
  std::vector<RobotState> one = speeding_up({5}), two = speeding_up({0, 8});
  set_speeds_from_poses(one);
  EXPECT_EQ(one[0].tcp_speed[2], 0);
  set_speeds_from_poses(two);
  EXPECT_NEAR(two[0].tcp_speed[2], 0.01 + 1.2 * 0.004, 1e-9);
  EXPECT_NEAR(two[1].tcp_speed[2], 0.01 + 1.2 * 0.004, 1e-9);
}

TEST(SpeedsFromPoses, AreAsNoisyAsDocumented) {
  for (const auto& [period_ms, noise_factor] : {std::pair{8, 88.4}, {2, 64.5}}) {
    Random random(4);
    std::vector<RobotState> states;
    for (int i = 0; i < 20'000; ++i) {
      RobotState state;
      state.t = RobotTime{microseconds{1000 * period_ms * i}};
      state.tcp_pose[1] = 1e-5 * random.normal();
      states.push_back(state);
    }
    set_speeds_from_poses(states);
    double squares = 0;
    for (const RobotState& state : states) squares += state.tcp_speed[1] * state.tcp_speed[1];
    EXPECT_NEAR(std::sqrt(squares / 20'000.0), 1e-5 * noise_factor, 0.03 * 1e-5 * noise_factor);
  }
}

TEST(PosesFromSpeeds, AreTheDisplacementSinceTheFirstRow) {
  std::vector<RobotState> states = speeding_up({0, 8, 16, 300, 308});
  for (RobotState& state : states) {
    state.tcp_pose = {7, 7, 7, 7, 7, 7};
    state.tcp_speed = {0, -0.5, 1, 0.1, 0, 0};
  }
  set_poses_from_speeds(states);
  EXPECT_EQ(states[0].tcp_pose, (std::array<double, 6>{}));
  EXPECT_NEAR(states[2].tcp_pose[1], -0.008, 1e-12);
  EXPECT_NEAR(states[3].tcp_pose[2], 0.016, 1e-12) << "the displacement over a gap is not known";
  EXPECT_NEAR(states[4].tcp_pose[2], 0.024, 1e-12);
}

}  // namespace
}  // namespace tactile::robot
