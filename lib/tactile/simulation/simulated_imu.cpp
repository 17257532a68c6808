#include "tactile/simulation/simulated_imu.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace tactile::simulation {
namespace {

constexpr double standard_gravity_mm_s2 = 1e3 * events::standard_gravity;
constexpr double acceleration_limit_g = 4, acceleration_step_g = 4.0 / 32768;
constexpr double rate_limit_dps = 500, rate_step_dps = 500.0 / 32768;
constexpr double temperature_step_c = 1.0 / 512, temperature_noise_c = 0.015;
constexpr int samples_per_temperature = 8;  // it is measured 100 times per second

float measured(double value, double limit, double step) {
  return static_cast<float>(step * std::round(std::clamp(value, -limit, limit - step) / step));
}

std::array<double, 3> three_normals(double sigma, Random& random) {
  std::array<double, 3> values;
  for (double& value : values) value = sigma * random.normal();
  return values;
}

}  // namespace

std::vector<events::ImuSample> feel_run(const RunPlan& plan, CameraTime start, const ImuPhysics& physics, Random& random) {
  const double period_s = 1.0 / (physics.rate_hz * (1.0 + random.uniform(-physics.rate_error, physics.rate_error)));
  const double roll = cut_normal(physics.tilt_rad, random), pitch = cut_normal(physics.tilt_rad, random);
  const std::array<double, 3> up{std::sin(roll) * std::cos(pitch), -std::cos(roll) * std::cos(pitch), std::sin(pitch)};
  const std::array<double, 3> acceleration_bias = three_normals(physics.acceleration_bias_g, random);
  const std::array<double, 3> rate_bias = three_normals(physics.rate_bias_dps, random);
  const double temperature_c = drawn(physics.temperature_c, random);
  const std::int64_t step_us = physics.stamp_step.count(), end_us = std::llround(1e6 * plan.end_s);

  std::vector<events::ImuSample> samples;
  samples.reserve(static_cast<std::size_t>(plan.end_s / period_s) + 2);
  std::int64_t last_us = -1;
  float felt_c = 0;
  const double first_s = period_s * random.uniform();  // the sensor is not synchronised with the recording
  for (std::int64_t k = 0;; ++k) {
    const double t_s = first_s + period_s * static_cast<double>(k);
    const auto stamp_us = static_cast<std::int64_t>(1e6 * t_s + drawn(physics.delay_us, random)) / step_us * step_us;
    if (t_s > plan.end_s) return samples;
    if (k % samples_per_temperature == 0)
      felt_c = measured(temperature_c + temperature_noise_c * random.normal(), 1000, temperature_step_c);
    events::ImuSample sample;
    sample.temperature_c = felt_c;
    const double upward_g = 1.0 + (plan.arm_acceleration_at(t_s) + plan.vibration_acceleration_at(t_s)) / standard_gravity_mm_s2;
    const std::array<double, 3> acceleration_noise = three_normals(physics.acceleration_noise_g, random);
    const std::array<double, 3> rate_noise = three_normals(physics.rate_noise_dps, random);
    for (std::size_t i = 0; i < 3; ++i) {
      sample.acceleration_g[i] =
          measured(up[i] * upward_g + acceleration_bias[i] + acceleration_noise[i], acceleration_limit_g, acceleration_step_g);
      sample.angular_rate_dps[i] = measured(rate_bias[i] + rate_noise[i], rate_limit_dps, rate_step_dps);
    }
    if (stamp_us <= last_us || stamp_us > end_us) continue;
    last_us = stamp_us;
    sample.t = start + microseconds{stamp_us};
    samples.push_back(sample);
  }
}

}  // namespace tactile::simulation
