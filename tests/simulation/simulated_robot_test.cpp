#include "tactile/simulation/simulated_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planned_run.hpp"

namespace tactile::simulation {
namespace {

RobotPhysics without_noise() {
  RobotPhysics physics;
  physics.speed_noise_mm_s = {0, 0};
  physics.pose_noise_mm = 0;
  physics.lost_package_share = 0;
  return physics;
}

std::vector<robot::RobotState> states_of(const RunPlan& plan, const RobotPhysics& physics, std::uint64_t seed = 1) {
  Random random(seed);
  return log_robot(plan, planned_clocks(), physics, random).log.states;
}

double seconds_of(const robot::RobotState& state) {
  const RunClocks clocks = planned_clocks();
  return seconds_of(state.t, clocks.robot, clocks);
}

/// How far it has risen since the log began [mm].
double risen(const std::vector<robot::RobotState>& states, std::size_t i) {
  return 1e3 * (states[i].tcp_pose[2] - states.front().tcp_pose[2]);
}

TEST(LogRobot, CountsFromTheControllersFirstStampBeyondBothEndsOfTheCamera) {
  const std::vector<robot::RobotState> states = states_of(planned_run(), without_noise());
  EXPECT_EQ(us_of(states.front().t), planned_clocks().robot.reference_us);
  for (std::size_t i = 0; i < states.size(); ++i)
    ASSERT_EQ((states[i].t - states.front().t).count(), 8000 * static_cast<std::int64_t>(i));
  EXPECT_NEAR(seconds_of(states.front()), -0.5, 1e-9);
  EXPECT_GT(seconds_of(states.back()), 6.0 + 0.1 - 0.008);
  EXPECT_LT(seconds_of(states.back()), 6.0 + 0.6);
}

TEST(LogRobot, ShowsTheLiftWhenItHappens) {
  const std::vector<robot::RobotState> states = states_of(planned_run(), without_noise());
  // 3 mm/s are reached after 2.5 ms and seen at the next row; the arm lags as it begins to ring.
  const auto moves = std::find_if(states.begin(), states.end(),
                                  [](const robot::RobotState& s) { return seconds_of(s) > 3.0 && s.tcp_speed[2] > 0.003; });
  ASSERT_NE(moves, states.end());
  EXPECT_GT(seconds_of(*moves), 3.5);
  EXPECT_LT(seconds_of(*moves), 3.5 + 0.0025 / 0.7 + 0.009);
  // 80 mm/s, but for 1/15 s of acceleration at each end.
  EXPECT_NEAR(risen(states, states.size() - 1), 80 * (0.7 - 80.0 / 1200), 0.001);
  for (const std::size_t still : {0U, 1U, 3U, 4U, 5U}) EXPECT_EQ(states.back().tcp_pose[still], states.front().tcp_pose[still]);
}

TEST(LogRobot, HasSpeedsThatAddUpToItsPoses) {
  const std::vector<robot::RobotState> states = states_of(planned_run(), without_noise());
  double mm = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    mm += 1e3 * 0.5 * (states[i - 1].tcp_speed[2] + states[i].tcp_speed[2]) * 0.008 * 1.0001;  // of camera seconds
    ASSERT_NEAR(risen(states, i), mm, 0.08) << seconds_of(states[i]);
  }
}

TEST(LogRobot, GoesDownAndUpInATap) {
  const std::vector<robot::RobotState> states = states_of(planned_run(), without_noise());
  double lowest = 0, fastest = 0;
  for (std::size_t i = 0; i < states.size() && seconds_of(states[i]) < 0.9; ++i) {
    lowest = std::min(lowest, risen(states, i));
    fastest = std::min(fastest, 1e3 * states[i].tcp_speed[2]);
    if (seconds_of(states[i]) < 0.3) {
      EXPECT_EQ(risen(states, i), 0.0);
    }
  }
  EXPECT_NEAR(lowest, -4, 0.25);
  EXPECT_NEAR(fastest, -80, 12) << "twice the mean of 4 mm in 0.1 s";
  const auto later = std::find_if(states.begin(), states.end(), [](const robot::RobotState& s) { return seconds_of(s) > 0.95; });
  EXPECT_NEAR(risen(states, static_cast<std::size_t>(later - states.begin())), 0, 0.01);
}

TEST(LogRobot, RingsAsTheCameraFeelsIt) {
  const RunPlan plan = planned_run();
  const std::vector<robot::RobotState> states = states_of(plan, without_noise());
  // The plan's acceleration, summed up twice in steps of 20 us.
  constexpr double step_s = 2e-5;
  double t_s = -0.5, speed = 0, travel = 0, most = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (; t_s < seconds_of(states[i]); t_s += step_s) {
      speed += step_s * plan.vibration_acceleration_at(t_s + 0.5 * step_s);
      travel += step_s * speed;
    }
    ASSERT_NEAR(1e3 * states[i].tcp_speed[2] - plan.arm_speed_at(seconds_of(states[i])), speed, 0.1) << seconds_of(states[i]);
    ASSERT_NEAR(risen(states, i) - plan.arm_travel_at(seconds_of(states[i])), travel, 0.01) << seconds_of(states[i]);
    most = std::max(most, std::abs(travel));
  }
  EXPECT_GT(most, 0.02) << "[mm] it does ring";
}

TEST(LogRobot, HasTheStagesCommandOnItsFirstOutputWhereTheRobotGivesIt) {
  RunPlan plan = planned_run();
  for (const robot::RobotState& state : states_of(plan, without_noise())) {
    const double t_s = seconds_of(state);
    const bool shut = (t_s >= 1.0 && t_s < 1.8) || t_s >= 2.5;
    ASSERT_EQ(state.digital_output_bits, shut ? 1U : 0U) << t_s;
  }
  plan.stage_on_robot_output = false;
  for (const robot::RobotState& state : states_of(plan, without_noise())) ASSERT_EQ(state.digital_output_bits, 0U);
}

TEST(LogRobot, LosesPackagesAndCountsThem) {
  RobotPhysics physics;
  physics.lost_package_share = 0.1;
  Random random(2);
  const LoggedRobot robot = log_robot(planned_run(), planned_clocks(), physics, random);
  const auto& states = robot.log.states;
  EXPECT_EQ(us_of(states.front().t), planned_clocks().robot.reference_us);
  for (const robot::RobotState& state : states) ASSERT_EQ((state.t - states.front().t).count() % 8000, 0);
  const auto spanned = static_cast<std::uint64_t>((states.back().t - states.front().t).count() / 8000 + 1);
  EXPECT_LE(spanned - states.size(), robot.dropped_packages) << "those after the last row are lost too";
  EXPECT_LE(robot.dropped_packages - (spanned - states.size()), 4U);
  EXPECT_NEAR(static_cast<double>(robot.dropped_packages), 0.1 * static_cast<double>(spanned), 35);
}

TEST(LogRobot, HasTheStatedNoise) {
  RobotPhysics physics;
  physics.speed_noise_mm_s = {0.4, 0.4};
  physics.pose_noise_mm = 0.02;
  const std::vector<robot::RobotState> states = states_of(planned_run(), physics);
  double speeds = 0, poses = 0, mean = 0;
  for (const robot::RobotState& state : states) mean += state.tcp_pose[0] / static_cast<double>(states.size());
  for (const robot::RobotState& state : states) {
    speeds += state.tcp_speed[0] * state.tcp_speed[0];
    poses += (state.tcp_pose[0] - mean) * (state.tcp_pose[0] - mean);
  }
  const auto rows = static_cast<double>(states.size());
  EXPECT_NEAR(1e3 * std::sqrt(speeds / rows), 0.4, 0.05);
  EXPECT_NEAR(1e3 * std::sqrt(poses / rows), 0.02, 0.0025);
}

TEST(LogRobot, RunsAtTheStatedRateAndIsTheSameForTheSameSeed) {
  RobotPhysics physics;
  physics.rate_hz = 300;
  physics.lost_package_share = 0;
  const std::vector<robot::RobotState> states = states_of(planned_run(), physics, 5),
                                       again = states_of(planned_run(), physics, 5);
  EXPECT_EQ((states[3].t - states[0].t).count(), 10'000);
  EXPECT_EQ((states[1].t - states[0].t).count(), 3333);
  ASSERT_EQ(states.size(), again.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    ASSERT_EQ(states[i].tcp_pose, again[i].tcp_pose);
    ASSERT_EQ(states[i].tcp_speed, again[i].tcp_speed);
  }
  EXPECT_NE(states_of(planned_run(), physics, 6)[0].tcp_pose, states[0].tcp_pose);
}

}  // namespace
}  // namespace tactile::simulation
