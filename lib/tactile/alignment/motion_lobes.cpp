#include "tactile/alignment/motion_lobes.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/straight_line.hpp"

namespace tactile::alignment {
namespace {

using Speed = SpeedProfile::Speed;

/// Where a straight line through points of time and speed meets zero.
UncertainSeconds zero_of_line(std::span<const WeightedPoint> points, const MotionRows& rows, bool rising) {
  const StraightLine line = line_through(points);
  if (points.size() < 2 || (rising ? line.gradient <= 0 : line.gradient >= 0)) return {};
  const double n = static_cast<double>(points.size());
  const double zero = line.mean_x - line.mean_y / line.gradient, lever = zero - line.mean_x;
  double squares = 0;
  for (const WeightedPoint& p : points) squares += std::pow(p.y - line.gradient * (p.x - zero), 2.0);
  const double sigma = std::max(rows.noise(), std::sqrt(squares / std::max(1.0, n - 2.0)));
  const double by_noise = sigma / std::abs(line.gradient) * std::sqrt(1.0 / n + lever * lever / line.weighted_xx);
  return {zero, std::hypot(by_noise, points.size() < 3 ? rows.period_s() : 0.3 * rows.period_s())};
}

}  // namespace

Speed direction_in(const MotionRows& rows, std::size_t begin, std::size_t end) {
  std::size_t fastest = begin;
  for (std::size_t i = begin; i < end; ++i) {
    if (rows.speed(i) > rows.speed(fastest)) fastest = i;
  }
  Speed direction = rows.rows()[fastest].speed;
  const double size = length_of(direction);
  for (double& part : direction) part /= size;
  return direction;
}

double least_dwell_s(const MotionRows& rows) { return std::max(0.04, 2.5 * rows.period_s()); }

std::vector<MotionLobe> lobes_in(const MotionRows& rows, std::size_t begin, std::size_t end, const Speed& direction) {
  std::vector<MotionLobe> lobes;
  int sign = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (!rows.moves(i)) continue;
    const double size = rows.speed(i), along = dot(rows.rows()[i].speed, direction);
    const int now = along >= 0.5 * size ? 1 : along <= -0.5 * size ? -1 : sign;
    const bool paused = !lobes.empty() && rows.t_s(i) - rows.t_s(lobes.back().end - 1) > least_dwell_s(rows);
    if (lobes.empty() || paused || (now != sign && sign != 0)) lobes.push_back({i, i, 0.0});
    sign = now == 0 ? 1 : now;
    lobes.back().end = i + 1;
    const double step_s = i > begin ? std::min(rows.t_s(i) - rows.t_s(i - 1), 0.05) : rows.period_s();
    lobes.back().displacement_m += sign * size * step_s;
  }
  double farthest_m = 0;
  for (const MotionLobe& lobe : lobes) farthest_m = std::max(farthest_m, std::abs(lobe.displacement_m));
  std::erase_if(lobes, [&](const MotionLobe& lobe) { return std::abs(lobe.displacement_m) < least_lobe_share * farthest_m; });
  return lobes;
}

LobeCorners corners_of(const MotionRows& rows, const MotionLobe& lobe) {
  std::vector<double> sizes;
  for (std::size_t i = lobe.begin; i < lobe.end; ++i) sizes.push_back(rows.speed(i));
  LobeCorners corners;
  corners.height = value_of_rank(sizes, sizes.size() * 4 / 5);
  const auto first_at = [&](double level) {
    std::size_t i = 0;
    while (i + 1 < sizes.size() && sizes[i] < level) ++i;
    return rows.t_s(lobe.begin + i);
  };
  const auto last_at = [&](double level) {
    std::size_t i = sizes.size() - 1;
    while (i > 0 && sizes[i] < level) --i;
    return rows.t_s(lobe.begin + i);
  };
  const double low_level = 0.2 * corners.height, high_level = 0.9 * corners.height, least_s = 0.5 * rows.period_s();
  const double rise_s = std::max(first_at(high_level) - first_at(low_level), least_s);
  const double fall_s = std::max(last_at(low_level) - last_at(high_level), least_s);
  corners.start_s = first_at(low_level) - 0.3 * rise_s;
  corners.up_s = first_at(high_level) + 0.1 * rise_s;
  corners.down_s = std::max(last_at(high_level) - 0.1 * fall_s, corners.up_s);
  corners.end_s = std::max(last_at(low_level) + 0.3 * fall_s, corners.down_s + least_s);
  return corners;
}

UncertainSeconds lobe_edge(const MotionRows& rows, const MotionLobe& lobe, bool is_start) {
  const double height = corners_of(rows, lobe).height;
  std::vector<WeightedPoint> points;
  for (std::size_t k = 0; k < lobe.end - lobe.begin; ++k) {
    const std::size_t row = is_start ? lobe.begin + k : lobe.end - 1 - k;
    const double size = rows.speed(row);
    if (size > 0.6 * height && points.size() > 1) break;
    if (size >= 0.1 * height) points.push_back({.x = rows.t_s(row), .y = size, .weight = 1});
    if (size > 0.6 * height) break;
  }
  const double rest_s = is_start ? rows.t_s(lobe.begin > 0 && !rows.gap_before(lobe.begin) ? lobe.begin - 1 : lobe.begin)
                                 : rows.t_s(lobe.end < rows.size() && !rows.gap_before(lobe.end) ? lobe.end : lobe.end - 1);
  const UncertainSeconds zero = points.empty() ? UncertainSeconds{} : zero_of_line(points, rows, is_start);
  const double moving_s = rows.t_s(is_start ? lobe.begin : lobe.end - 1);
  const bool is_likely =
      is_start ? zero.t_s <= moving_s && zero.t_s > rest_s - 0.05 : zero.t_s >= moving_s && zero.t_s < rest_s + 0.05;
  if (std::isfinite(zero.sigma_s) && is_likely) return zero;
  return {rest_s, std::max(rows.period_s(), std::abs(moving_s - rest_s))};
}

}  // namespace tactile::alignment
