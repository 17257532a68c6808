#include "tactile/robot/mixed_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tactile/core/duration_units.hpp"

namespace tactile::robot {
namespace {

constexpr double least_change = 5e-4;  // [m/s] from row to row: a smaller one does not matter
constexpr double moving = 0.005;       // [m/s] or [rad/s]: rows of an arm at rest may be equal

double distance(const std::array<double, 6>& a, const std::array<double, 6>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Whether `first` and `second` have one value, other than their neighbours'.
bool is_twice(const std::array<double, 6>& before, const std::array<double, 6>& first, const std::array<double, 6>& second,
              const std::array<double, 6>& after) {
  return first == second && before != first && second != after;
}

/// The distance of a row's speed from the line between two others [m/s].
double speed_off_line(const RobotState& before, const RobotState& row, const RobotState& after) {
  const double share = in_s(row.t - before.t) / in_s(after.t - before.t);
  std::array<double, 6> between{};
  for (std::size_t k = 0; k < 3; ++k) between[k] = before.tcp_speed[k] + share * (after.tcp_speed[k] - before.tcp_speed[k]);
  return distance(row.tcp_speed, between);
}

/// The distance of a row's pose from the cubic through two others with their speeds; without speeds, from the line [m].
double pose_off_curve(const RobotState& before, const RobotState& row, const RobotState& after, bool has_speeds) {
  const double all_s = in_s(after.t - before.t), s = in_s(row.t - before.t) / all_s;
  std::array<double, 6> between{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double step = after.tcp_pose[k] - before.tcp_pose[k];
    between[k] = before.tcp_pose[k] + s * step;
    if (has_speeds) {
      const double u = before.tcp_speed[k] * all_s, v = after.tcp_speed[k] * all_s;
      between[k] += s * (1.0 - s) * ((1.0 - s) * (u - step) - s * (v - step));
    }
  }
  return distance(row.tcp_pose, between);
}

/// The smallest step of a pose from row to row: the last digit of a log with few digits, and nearly 0 in any other.
double resolution_of_poses(const std::vector<RobotState>& states) {
  double resolution = std::numeric_limits<double>::max();
  for (std::size_t i = 1; i < states.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = std::abs(states[i].tcp_pose[k] - states[i - 1].tcp_pose[k]);
      if (step > 0) resolution = std::min(resolution, step);
    }
  }
  return resolution;
}

}  // namespace

void drop_mixed_rows(RobotLog& log, bool has_speeds, bool has_poses) {
  const std::vector<RobotState>& states = log.states;
  std::vector<bool> dropped(states.size(), false);
  const double by_rounding = 6.0 * resolution_of_poses(states);  // a slower arm has equal rows, because they were rounded
  for (std::size_t i = 1; i + 2 < states.size(); ++i) {
    const RobotState &before = states[i - 1], &first = states[i], &second = states[i + 1], &after = states[i + 2];
    if (dropped[i - 1] || dropped[i] || after.t - before.t > longest_row_step) continue;
    const bool pose_twice = is_twice(before.tcp_pose, first.tcp_pose, second.tcp_pose, after.tcp_pose) &&
                            distance(before.tcp_pose, after.tcp_pose) > std::max(moving * in_s(after.t - before.t), by_rounding);
    const bool speed_twice = is_twice(before.tcp_speed, first.tcp_speed, second.tcp_speed, after.tcp_speed) &&
                             distance(before.tcp_speed, first.tcp_speed) > least_change &&
                             distance(second.tcp_speed, after.tcp_speed) > least_change &&
                             std::max(distance(before.tcp_speed, {}), distance(after.tcp_speed, {})) > moving;
    if (!pose_twice && !speed_twice) continue;
    const auto off = [&](const RobotState& row) {  // a pose is better, since it changes all the time
      return pose_twice ? pose_off_curve(before, row, after, has_speeds && has_poses) : speed_off_line(before, row, after);
    };
    dropped[off(first) > off(second) ? i : i + 1] = true;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!dropped[i]) log.states[kept++] = states[i];
  }
  log.mixed_rows += states.size() - kept;
  log.states.resize(kept);
}

}  // namespace tactile::robot
