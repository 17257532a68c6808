#include "tactile/robot/motion_phases.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tactile/core/random.hpp"

namespace tactile {
namespace {

/// A trapezoidal lift sampled every 8 ms: rises from `start_us` with 1.2 m/s², cruises, and falls alike.
RobotLog lift(double start_us, double cruise_us, double speed, double noise, std::uint64_t seed) {
  const double ramp_us = speed / 1.2 * 1e6;
  Random random(seed);
  RobotLog log;
  double height = 0.2;
  for (double t = 0; t < 3e6; t += 8'000) {
    const double u = t - start_us;
    const double v = speed * std::clamp(std::min(u / ramp_us, (2 * ramp_us + cruise_us - u) / ramp_us), 0.0, 1.0);
    height += v * 0.008;
    RobotState state;
    state.t = RobotTime{microseconds{static_cast<std::int64_t>(t)}};
    state.tcp_pose[2] = height;
    for (int axis = 0; axis < 3; ++axis) state.tcp_speed[static_cast<std::size_t>(axis)] = noise * random.normal();
    state.tcp_speed[2] += v;
    log.states.push_back(state);
  }
  return log;
}

double ms(RobotTime t) { return static_cast<double>(us_of(t)) / 1000.0; }

TEST(MotionPhases, FindStartAndEndOfALiftBetweenTheRows) {
  for (const double start_us : {1'000'000.0, 1'002'500.0, 1'006'100.0}) {
    const auto phases = motion_phases(lift(start_us, 400'000, 0.06, 0.0, 1));
    ASSERT_EQ(phases.size(), 1U);
    EXPECT_NEAR(ms(phases[0].start), start_us / 1000.0, 0.1);
    EXPECT_NEAR(ms(phases[0].end), start_us / 1000.0 + 500.0, 0.1);
    EXPECT_NEAR(phases[0].peak_speed, 0.06, 1e-9);
    EXPECT_NEAR(phases[0].height_change, 0.06 * 0.45, 0.001);
  }
}

TEST(MotionPhases, FindItInNoiseToMilliseconds) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto phases = motion_phases(lift(1'003'000, 400'000, 0.04, 4e-4, seed));
    ASSERT_EQ(phases.size(), 1U) << "seed " << seed;
    EXPECT_NEAR(ms(phases[0].start), 1'003.0, 2.5) << "seed " << seed;
  }
}

TEST(MotionPhases, OfARestingArmAreNone) {
  EXPECT_TRUE(motion_phases(lift(9e9, 0, 0.06, 4e-4, 2)).empty());
  EXPECT_TRUE(motion_phases({}).empty());
}

}  // namespace
}  // namespace tactile
