#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tactile/alignment/speed_profile.hpp"
#include "tactile/core/random.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::test {

/// What an arm is commanded, and how it rings.
struct MadeMotion {
  std::vector<double> knots_s{};    ///< straight lines from knot to knot
  std::vector<double> speeds{};     ///< [m/s] at the knots, upwards
  alignment::ArmRinging ringing{};  ///< none
  std::array<double, 3> direction{0, 0, 1};
  double noise = 3e-4;       ///< [m/s] each axis
  double pose_noise = 1e-5;  ///< [m]
  double lost_share = 0.004;
  int period_ms = 8;
  double length_s = 4;
  std::uint64_t seed = 1;
};

/// A trapezium from `start_s` on.
inline void add_move(MadeMotion& motion, double start_s, double lasts_s, double speed, double acceleration = 1.2) {
  const double ramp_s = std::min(std::abs(speed) / acceleration, 0.5 * lasts_s);
  motion.knots_s.insert(motion.knots_s.end(), {start_s, start_s + ramp_s, start_s + lasts_s - ramp_s, start_s + lasts_s});
  motion.speeds.insert(motion.speeds.end(), {0, speed, speed, 0});
}

/// Down and up again: speeds up, brakes, comes back with the same speeds.
inline void add_tap(MadeMotion& motion, double start_s, double lasts_s, double peak_speed) {
  motion.knots_s.insert(motion.knots_s.end(), {start_s, start_s + 0.25 * lasts_s, start_s + 0.75 * lasts_s, start_s + lasts_s});
  motion.speeds.insert(motion.speeds.end(), {0, -peak_speed, peak_speed, 0});
}

inline double commanded(const MadeMotion& motion, double t_s) {
  for (std::size_t k = 1; k < motion.knots_s.size(); ++k) {
    const double from = motion.knots_s[k - 1], to = motion.knots_s[k];
    if (t_s < from || t_s >= to) continue;
    return motion.speeds[k - 1] + (motion.speeds[k] - motion.speeds[k - 1]) * (t_s - from) / (to - from);
  }
  return 0;
}

/// The log of it. The ringing is that of a mass on a spring, x'' + 2 d x' + (w^2 + d^2) x = -share a, step by step.
inline robot::RobotLog log_of(const MadeMotion& motion) {
  constexpr double step_s = 2e-5;
  const double w = 2.0 * std::numbers::pi * motion.ringing.hz;
  const double d = motion.ringing.decay_s > 0 ? 1.0 / motion.ringing.decay_s : 1.0;
  Random random(motion.seed);
  robot::RobotLog log;
  double travel = 0, x = 0, v = 0;
  const auto steps = static_cast<std::int64_t>(std::llround(motion.length_s / step_s));
  const auto per_row = static_cast<std::int64_t>(std::llround(1e-3 * motion.period_ms / step_s));
  for (std::int64_t i = 0; i < steps; ++i) {
    const double t_s = step_s * static_cast<double>(i);
    if (i % per_row == 0 && !(i > 0 && random.uniform() < motion.lost_share)) {
      robot::RobotState state;
      state.t = RobotTime{microseconds{1'000'000'000 + 20 * i}};
      state.tcp_pose = {-0.4, 0.2, 0.3, 2.2, -2.2, 0};
      for (std::size_t a = 0; a < 3; ++a) {
        state.tcp_pose[a] += motion.direction[a] * (travel + x) + motion.pose_noise * random.normal();
        state.tcp_speed[a] = motion.direction[a] * (commanded(motion, t_s) + v) + motion.noise * random.normal();
      }
      log.states.push_back(state);
    }
    const double now = commanded(motion, t_s), next = commanded(motion, t_s + step_s);
    travel += 0.5 * step_s * (now + next);
    if (motion.ringing.share > 0) {
      v += step_s * (-motion.ringing.share * (next - now) / step_s - 2.0 * d * v - (w * w + d * d) * x);
      x += step_s * v;
    }
  }
  return log;
}

/// Seconds since the log's first row.
inline double seconds(const robot::RobotLog&, RobotTime t) { return 1e-6 * static_cast<double>(us_of(t) - 1'000'000'000); }

}  // namespace tactile::test
