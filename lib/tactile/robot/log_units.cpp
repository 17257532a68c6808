#include "tactile/robot/log_units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::robot {
namespace {

constexpr std::size_t fewest_rows = 10;
constexpr double longest_step_s = 0.5;  // 500 rows a second in milliseconds are 2 apart
constexpr double farthest_m = 10, most_turned_rad = 7, fastest_m_s = 10, fastest_turn_rad_s = 30;

/// The greatest of |values| of the elements [begin, end).
double greatest(const std::array<double, 6>& values, std::size_t begin, std::size_t end) {
  double most = 0;
  for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(values.at(i)));
  return most;
}

std::string too_large(std::string_view column, int first, int last, double value, std::string_view bound,
                      std::string_view expected, std::string_view remedy) {
  return fmt::format("{}_{} to _{} have values of {:.4g}, {}; expected {}: {}", column, first, last, value, bound, expected,
                     remedy);
}

std::string refused_times(const std::vector<double>& steps_s) {
  const double step = median(steps_s);
  if (step <= longest_step_s) return {};
  double factor = 1e3;
  while (step / factor > longest_step_s) factor *= 1e3;
  const std::string_view unit = factor == 1e3 ? "milliseconds" : factor == 1e6 ? "microseconds" : "nanoseconds";
  return fmt::format(
      "timestamp: the rows are {:.4g} apart (median); expected seconds, and more than two rows a second: divide {} by {:.0f}",
      step, unit, factor);
}

}  // namespace

std::string other_units(std::span<const RobotLog> pieces, const LoggedColumns& columns) {
  std::vector<double> steps_s, places, turns, speeds, turning;
  const RobotState* before = nullptr;
  constexpr std::size_t judged_joints = 5;  // the last one of an e-Series arm turns without end
  for (const RobotLog& piece : pieces) {
    for (const RobotState& state : piece.states) {
      if (before != nullptr && state.t > before->t)
        steps_s.push_back(1e-6 * static_cast<double>(saturating_subtract(us_of(state.t), us_of(before->t))));
      before = &state;
      places.push_back(greatest(state.tcp_pose, 0, 3));
      turns.push_back(columns.pose_is_joints ? greatest(state.tcp_pose, 0, judged_joints) : greatest(state.tcp_pose, 3, 6));
      speeds.push_back(greatest(state.tcp_speed, 0, 3));
      turning.push_back(greatest(state.tcp_speed, 3, 6));
    }
  }
  if (places.size() < fewest_rows) return {};
  if (std::string refused = refused_times(steps_s); !refused.empty()) return refused;

  constexpr std::string_view in_m =
      "convert the values (millimetres: divide by 1000; centimetres: by 100; inches: multiply by 0.0254)";
  constexpr std::string_view in_rad = "multiply degrees by 0.0174533";
  if (!columns.pose.empty()) {
    const double place = median(places), turn = median(turns);
    if (!columns.pose_is_joints && place > farthest_m)
      return too_large(columns.pose, 0, 2, place, "where no arm reaches", "metres", in_m);
    if (turn > most_turned_rad)
      return too_large(columns.pose, columns.pose_is_joints ? 0 : 3, 5, turn, "more than a turn", "radians", in_rad);
  }
  if (columns.speed.empty()) return {};
  const auto tenth_greatest = [](const std::vector<double>& values) {
    return value_of_rank<double>(values, fewest_rows - 1, std::greater<>());
  };
  const double speed = tenth_greatest(speeds), turned = tenth_greatest(turning);
  if (speed > fastest_m_s) return too_large(columns.speed, 0, 2, speed, "faster than any arm", "m/s", in_m);
  if (turned > fastest_turn_rad_s) return too_large(columns.speed, 3, 5, turned, "faster than any arm", "rad/s", in_rad);
  return {};
}

}  // namespace tactile::robot
