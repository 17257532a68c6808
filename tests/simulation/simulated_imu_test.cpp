#include "tactile/simulation/simulated_imu.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planned_run.hpp"

namespace tactile::simulation {
namespace {

constexpr double gravity_mm_s2 = 9806.65;
constexpr CameraTime start = camera_time(1'700'000'000'000'000);

ImuPhysics upright_without_bias() {
  ImuPhysics physics;
  physics.tilt_rad = 0;
  physics.acceleration_bias_g = 0;
  physics.rate_bias_dps = 0;
  return physics;
}

/// Stamped at once and to the microsecond.
ImuPhysics without_faults() {
  ImuPhysics physics = upright_without_bias();
  physics.delay_us = {0, 0};
  physics.stamp_step = 1us;
  physics.acceleration_noise_g = 0;
  physics.rate_noise_dps = 0;
  return physics;
}

std::vector<events::ImuSample> felt(const RunPlan& plan, const ImuPhysics& physics, std::uint64_t seed = 1) {
  Random random(seed);
  return feel_run(plan, start, physics, random);
}

double seconds_of(const events::ImuSample& sample) { return 1e-6 * static_cast<double>((sample.t - start).count()); }

TEST(FeelRun, FeelsGravityAlongTheImagesYAxis) {
  RunPlan plan;
  plan.end_s = 20;
  const std::vector<events::ImuSample> samples = felt(plan, upright_without_bias());
  double mean[3] = {}, squares = 0, turns = 0;
  for (const events::ImuSample& sample : samples) {
    for (int i = 0; i < 3; ++i) mean[i] += sample.acceleration_g[i] / static_cast<double>(samples.size());
    squares += sample.acceleration_g[0] * sample.acceleration_g[0];
    turns += sample.angular_rate_dps[2] * sample.angular_rate_dps[2];
    EXPECT_GE(sample.temperature_c, 32 - 0.1);
    EXPECT_LE(sample.temperature_c, 42 + 0.1);
    EXPECT_EQ(sample.magnetic_field_ut[0], 0) << "it has no compass";
  }
  EXPECT_NEAR(mean[0], 0, 1e-4);
  EXPECT_NEAR(mean[1], -1, 1e-4);
  EXPECT_NEAR(mean[2], 0, 1e-4);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(samples.size())), 0.003, 1e-4);
  EXPECT_NEAR(std::sqrt(turns / static_cast<double>(samples.size())), 0.1, 3e-3);
}

TEST(FeelRun, IsTiltedAndBiasedDifferentlyInEveryRun) {
  RunPlan plan;
  plan.end_s = 0.2;
  ImuPhysics physics = without_faults();
  physics.tilt_rad = 0.05;
  double squares = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const events::ImuSample sample = felt(plan, physics, seed).front();
    const float* a = sample.acceleration_g;
    EXPECT_NEAR(std::hypot(a[0], a[1], a[2]), 1, 1e-3) << "gravity is turned, not changed";
    squares += a[0] * a[0];
  }
  EXPECT_NEAR(std::sqrt(squares / 300), 0.05, 0.01);
  physics.tilt_rad = 0;
  physics.acceleration_bias_g = 0.02;
  EXPECT_NE(felt(plan, physics, 1).front().acceleration_g[0], felt(plan, physics, 2).front().acceleration_g[0]);
}

TEST(FeelRun, StaysWithinTheRecordingWithTimesOfReadOutsThatAscend) {
  const RunPlan plan = planned_run();
  int unlike = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<events::ImuSample> samples = felt(plan, {}, seed);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      ASSERT_EQ((samples[i].t - start).count() % 200, 0);
      if (i == 0) continue;
      ASSERT_LT(samples[i - 1].t, samples[i].t);
      ASSERT_NEAR(static_cast<double>((samples[i].t - samples[i - 1].t).count()), 1250, 451);
      unlike += (samples[i].t - samples[i - 1].t) != 1200us;
    }
    EXPECT_GE(samples.front().t, start);
    EXPECT_LE(samples.back().t, start + 6s);
    EXPECT_LT(samples.front().t, start + 2ms);
    EXPECT_GT(samples.back().t, start + 6s - 2ms);
    const double hz = static_cast<double>(samples.size() - 1) / (seconds_of(samples.back()) - seconds_of(samples.front()));
    EXPECT_NEAR(hz, 800, 9);
  }
  EXPECT_GT(unlike, 20 * 500);
}

TEST(FeelRun, KeepsTimesApartWhereSamplesComeFasterThanStamps) {
  ImuPhysics physics;
  physics.rate_hz = 3200;
  physics.stamp_step = 1000us;
  const std::vector<events::ImuSample> samples = felt(planned_run(), physics);
  EXPECT_NEAR(static_cast<double>(samples.size()), 6000, 3);
  for (std::size_t i = 1; i < samples.size(); ++i) ASSERT_LT(samples[i - 1].t, samples[i].t);
}

TEST(FeelRun, FeelsTheArmsAccelerationAndItsRinging) {
  const RunPlan plan = planned_run();
  double rings = 0;
  for (const events::ImuSample& sample : felt(plan, without_faults())) {
    const double t_s = seconds_of(sample);
    // A stamp is up to a microsecond early: so its side of a change is unknown.
    const double at = plan.arm_acceleration_at(t_s) + plan.vibration_acceleration_at(t_s);
    const double after = plan.arm_acceleration_at(t_s + 1e-6) + plan.vibration_acceleration_at(t_s + 1e-6);
    const double up_g = -sample.acceleration_g[1] - 1;
    ASSERT_LT(std::min(std::abs(up_g - at / gravity_mm_s2), std::abs(up_g - after / gravity_mm_s2)), 1e-4) << t_s;
    if (t_s > 4.21 && t_s < 4.4) rings = std::max(rings, std::abs(up_g));
  }
  EXPECT_GT(rings, 0.01) << "the arm stands still by then";
}

TEST(FeelRun, AddsUpToTheLiftsTravel) {
  // Once for speed, once more for travel; what it feels before the lift is subtracted.
  const RunPlan plan = planned_run();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const std::vector<events::ImuSample> samples = felt(plan, upright_without_bias(), seed);
    double rest = 0, rests = 0;
    for (const events::ImuSample& sample : samples) {
      if (seconds_of(sample) > 0.8 && seconds_of(sample) < 3.4) {
        rest -= sample.acceleration_g[1];
        ++rests;
      }
    }
    rest /= rests;
    double speed = 0, travel = 0;
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const double t_s = seconds_of(samples[i]), step_s = t_s - seconds_of(samples[i - 1]);
      if (t_s < 3.45 || t_s > 4.5) continue;
      speed += step_s * gravity_mm_s2 * (-samples[i].acceleration_g[1] - rest);
      travel += step_s * speed;
    }
    EXPECT_NEAR(travel, 80 * (0.7 - 80.0 / 1200), 5) << seed;
    EXPECT_NEAR(speed, 0, 10) << seed;
  }
}

TEST(FeelRun, FeelsNoMoreThanItsRange) {
  RunPlan plan = planned_run();
  plan.lift->acceleration_mm_s2 = 1e5;
  plan.lift->speed_mm_s = 2000;
  double most = 0;
  for (const events::ImuSample& sample : felt(plan, {}))
    most = std::max(most, std::abs(static_cast<double>(sample.acceleration_g[1])));
  EXPECT_EQ(most, 4);
}

}  // namespace
}  // namespace tactile::simulation
