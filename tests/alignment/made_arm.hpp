#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::test {

/// An arm that goes up and down the base's z axis and rings where its acceleration changes, as a mass on a spring does. Times in
/// seconds, metres.
class MadeArm {
 public:
  double ringing_share = 0, ringing_hz = 18, ringing_decay_s = 0.08;

  /// Speeds up, moves evenly, brakes.
  void lift(double start_s, double lasts_s, double speed, double acceleration = 1.2) {
    const double ramp_s = speed / acceleration;
    change(start_s, acceleration);
    change(start_s + ramp_s, -acceleration);
    change(start_s + lasts_s - ramp_s, -acceleration);
    change(start_s + lasts_s, acceleration);
  }

  /// Down and up again, lowest in the middle.
  void tap(double start_s, double lasts_s, double travel) {
    const double a = 16.0 * travel / (lasts_s * lasts_s);
    change(start_s, -a);
    change(start_s + 0.25 * lasts_s, 2 * a);
    change(start_s + 0.75 * lasts_s, -2 * a);
    change(start_s + lasts_s, a);
  }

  double commanded_speed(double t_s) const {
    double v = 0;
    for (const auto& [at_s, step] : changes_) v += step * std::max(0.0, t_s - at_s);
    return std::abs(v) < 1e-12 ? 0.0 : v;
  }
  double speed(double t_s) const {
    const double w = 2 * std::numbers::pi * ringing_hz;
    double v = commanded_speed(t_s);
    for (const auto& [at_s, step] : changes_) {
      const double since = t_s - at_s;
      if (since > 0) v -= ringing_share * step / w * std::exp(-since / ringing_decay_s) * std::sin(w * since);
    }
    return v;
  }
  double acceleration(double t_s) const { return (speed(t_s + 1e-5) - speed(t_s - 1e-5)) / 2e-5; }

  /// Rows from `from_s` to `to_s` of the arm's time, whose 0 the controller counts as `zero_us` and whose second it takes for
  /// 1 + `fast_ppm` millionths.
  robot::RobotLog log(double from_s, double to_s, std::int64_t zero_us = 0, double fast_ppm = 0, double period_s = 0.008,
                      double noise = 3e-4, std::uint64_t seed = 5) const {
    Random random(seed);
    robot::RobotLog log;
    double height = 0.3;
    for (double t = from_s; t < to_s; t += period_s) {
      robot::RobotState state;
      state.t = RobotTime{microseconds{zero_us + std::llround(1e6 * t * (1.0 + 1e-6 * fast_ppm))}};
      height += period_s * speed(t);
      state.tcp_pose = {0.1, 0.2, height, 0, 0, 0};
      state.tcp_speed = {noise * random.normal(), noise * random.normal(), speed(t) + noise * random.normal(), 0, 0, 0};
      log.states.push_back(state);
    }
    return log;
  }

 private:
  void change(double at_s, double step) { changes_.emplace_back(at_s, step); }

  std::vector<std::pair<double, double>> changes_;
};

}  // namespace tactile::test
