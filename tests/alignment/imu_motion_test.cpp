#include "tactile/alignment/imu_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tactile::alignment {
namespace {

/// A camera that looks along (0.6, 0, 0.8) of its own axes and is pushed that way at 2 m/s^2 from 1.0 to 1.1 s.
std::vector<events::ImuSample> pushed_camera(std::int64_t begin_us, double seconds) {
  std::vector<events::ImuSample> samples;
  for (int i = 0; 0.00125 * i < seconds; ++i) {
    const double t = 0.00125 * i;
    const double push_g = t >= 1.0 && t < 1.1 ? 2.0 / 9.80665 : 0.0;
    events::ImuSample sample;
    sample.t = camera_time(begin_us + std::llround(1e6 * t));
    sample.acceleration_g[0] = static_cast<float>(0.02 + 0.6 * push_g);
    sample.acceleration_g[1] = -1.0F;
    sample.acceleration_g[2] = static_cast<float>(0.8 * push_g);
    samples.push_back(sample);
  }
  return samples;
}

/// What the push gave: samples are 1.25 ms apart.
double speed_along_z(const ImuMotion& motion) {
  double speed = 0;
  for (const Vector3& a : motion.acceleration) speed += 0.00125 * a[2];
  return speed;
}

TEST(ImuMotion, IsWithoutGravityAndBias) {
  const ImuMotion motion = imu_motion(pushed_camera(1'000, 4));
  ASSERT_EQ(motion.t.size(), 3'200U);
  EXPECT_NEAR(motion.acceleration[100][0], 0.0, 1e-6);
  EXPECT_NEAR(motion.acceleration[100][1], 0.0, 1e-6);
  EXPECT_NEAR(motion.acceleration[840][0], 1.2, 1e-5);
  EXPECT_NEAR(motion.acceleration[840][2], 1.6, 1e-5);
  EXPECT_NEAR(speed_along_z(motion), 0.16, 0.003);
}

TEST(ImuMotion, FollowsACameraThatIsTurned) {
  std::vector<events::ImuSample> samples = pushed_camera(0, 12);
  for (events::ImuSample& sample : samples) {  // upside down from 6 s on
    if (us_of(sample.t) >= 6'000'000) sample.acceleration_g[1] = 1.0F;
  }
  const ImuMotion motion = imu_motion(samples);
  EXPECT_NEAR(motion.acceleration[100][1], 0.0, 1e-6);
  EXPECT_NEAR(motion.acceleration.back()[1], 0.0, 1e-6);
}

TEST(ImuMotion, LeavesOutWhatComesOutOfOrderOrIsNoNumber) {
  std::vector<events::ImuSample> samples = pushed_camera(0, 1);
  samples[10].t = samples[9].t;
  samples[20].acceleration_g[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(imu_motion(samples).t.size(), samples.size() - 2);
  EXPECT_TRUE(imu_motion({}).t.empty());
}

TEST(ImuMotion, PassesOverAGapOfHours) {
  std::vector<events::ImuSample> samples = pushed_camera(std::numeric_limits<std::int64_t>::min(), 3);
  const std::vector<events::ImuSample> later = pushed_camera(std::numeric_limits<std::int64_t>::max() - 10'000'000, 3);
  samples.insert(samples.end(), later.begin(), later.begin() + 800);
  const ImuMotion motion = imu_motion(std::vector<events::ImuSample>(samples.begin(), samples.begin() + 2'400));
  EXPECT_NEAR(speed_along_z(motion), 0.16, 0.003);
  std::vector<events::ImuSample> apart = pushed_camera(0, 3);
  for (std::size_t i = 1'600; i < apart.size(); ++i) apart[i].t += std::chrono::hours(5);
  const ImuMotion both = imu_motion(apart);
  EXPECT_NEAR(speed_along_z(both), 0.16, 0.003);
}

}  // namespace
}  // namespace tactile::alignment
