#include "tactile/simulation/simulated_robot.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace tactile::simulation {
namespace {

constexpr double rotation_noise_rad_per_mm = 1e-3;   // joints of an arm about a metre long
constexpr double rotation_speed_noise_factor = 3.0;  // the wrist's joints are coarser

/// Rounded as a log prints it: more digits than the encoders provide only make files larger.
double rounded(double value) { return std::round(value * 1e7) / 1e7; }

/// The contribution of the arm's ringing to its motion.
struct Ringing {
  double travel_mm = 0;
  double speed_mm_s = 0;
};

/// The motion with the plan's acceleration: after a change c of the arm's acceleration the arm lags by share c / (w^2 + d^2) and
/// swings around that,
///
///   x = -share c / (w^2 + d^2) (1 - e^(-d t) (cos w t + d / w sin w t)),   x' = -share c / w e^(-d t) sin w t
Ringing ringing_at(const VibrationPlan& vibration, const std::vector<std::pair<double, double>>& changes, double t_s) {
  const double w = 2.0 * std::numbers::pi * vibration.hz, d = 1.0 / vibration.decay_s;
  Ringing ringing;
  for (const auto& [at_s, change] : changes) {
    const double since = t_s - at_s;
    if (since <= 0) break;
    const double left = vibration.housing_share * change * std::exp(-d * since), sine = std::sin(w * since);
    ringing.travel_mm -= (vibration.housing_share * change - left * (std::cos(w * since) + d / w * sine)) / (w * w + d * d);
    ringing.speed_mm_s -= left / w * sine;
  }
  return ringing;
}

}  // namespace

LoggedRobot log_robot(const RunPlan& plan, const RunClocks& clocks, const RobotPhysics& physics, Random& random) {
  const double speed_noise = 1e-3 * drawn(physics.speed_noise_mm_s, random);  // [m/s]
  std::array<double, 6> place{random.uniform(-0.6, -0.4), random.uniform(0.1, 0.3), random.uniform(0.2, 0.3), 0, 0, 0};
  for (std::size_t i = 3; i < 6; ++i) place[i] = random.uniform(-2.0, 2.0);
  const std::vector<std::pair<double, double>> changes = plan.arm_acceleration_changes();
  const double end_s = plan.end_s + drawn(physics.after_camera_s, random);

  LoggedRobot robot;
  for (std::int64_t k = 0;; ++k) {
    robot::RobotState state;
    state.t = RobotTime{microseconds{clocks.robot.reference_us + (2'000'000 * k + physics.rate_hz) / (2 * physics.rate_hz)}};
    const double t_s = 1e-6 * static_cast<double>(us_of(clocks.robot.camera_from(state.t)) - clocks.camera_start_us);
    if (t_s > end_s) break;
    if (k > 0 && random.uniform() < physics.lost_package_share) {
      ++robot.dropped_packages;
      continue;
    }
    const Ringing ringing = ringing_at(plan.vibration, changes, t_s);
    state.tcp_pose = place;
    state.tcp_pose[2] += 1e-3 * (plan.arm_travel_at(t_s) + ringing.travel_mm);
    state.tcp_speed[2] = 1e-3 * (plan.arm_speed_at(t_s) + ringing.speed_mm_s);
    for (std::size_t i = 0; i < 6; ++i) {
      const bool turns = i >= 3;
      const double pose_noise = physics.pose_noise_mm * (turns ? rotation_noise_rad_per_mm : 1e-3);
      state.tcp_pose[i] = rounded(state.tcp_pose[i] + pose_noise * random.normal());
      state.tcp_speed[i] =
          rounded(state.tcp_speed[i] + (turns ? rotation_speed_noise_factor : 1.0) * speed_noise * random.normal());
    }
    state.digital_output_bits = plan.stage_on_robot_output && plan.stage_commanded_at(t_s) ? 1 : 0;
    robot.log.states.push_back(state);
  }
  return robot;
}

}  // namespace tactile::simulation
