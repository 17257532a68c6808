#include "tactile/alignment/arm_motion.hpp"

namespace tactile::alignment {

std::optional<ArmMotion> arm_motion(const robot::RobotLog& log, const ArmMotionOptions& options) {
  const std::vector<robot::RobotState>& states = log.states;
  if (states.size() < 2) return std::nullopt;
  const std::int64_t points = saturating_subtract(us_of(states.back().t), us_of(states.front().t)) / options.step.count() + 1;
  if (points < 2 || static_cast<std::uint64_t>(points) > options.most_points) return std::nullopt;
  const auto n = static_cast<std::size_t>(points);
  ArmMotion motion{.begin = states.front().t,
                   .step = options.step,
                   .velocity = std::vector<Vector3>(n),
                   .acceleration = std::vector<Vector3>(n),
                   .known = std::vector<bool>(n)};
  std::size_t row = 0, gap = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const RobotTime t = motion.time_of(i);
    while (row + 2 < states.size() && states[row + 1].t <= t) ++row;
    const robot::RobotState &a = states[row], &b = states[row + 1];
    while (gap < log.gaps.size() && log.gaps[gap].first_after <= a.t) ++gap;
    const bool in_gap = gap < log.gaps.size() && log.gaps[gap].last_before <= a.t && t > a.t;
    if (b.t - a.t > options.longest_gap || in_gap) continue;
    motion.known[i] = true;
    const double share = static_cast<double>((t - a.t).count()) / static_cast<double>((b.t - a.t).count());
    for (std::size_t k = 0; k < 3; ++k) motion.velocity[i][k] = (1.0 - share) * a.tcp_speed[k] + share * b.tcp_speed[k];
  }
  const double step_s = 1e-6 * static_cast<double>(options.step.count());
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!motion.known[i] || !motion.known[i + 1]) continue;
    for (std::size_t k = 0; k < 3; ++k) motion.acceleration[i][k] = (motion.velocity[i + 1][k] - motion.velocity[i][k]) / step_s;
  }
  return motion;
}

}  // namespace tactile::alignment
