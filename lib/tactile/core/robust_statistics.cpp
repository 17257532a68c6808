#include "tactile/core/robust_statistics.hpp"

#include <cassert>
#include <cmath>

namespace tactile {

std::vector<double> distances_from(double centre, std::span<const double> values) {
  std::vector<double> distances(values.begin(), values.end());
  for (double& value : distances) value = std::abs(value - centre);
  return distances;
}

double quantile(std::span<const double> values, double q) {
  assert(q >= 0 && q <= 1);
  if (values.empty()) return 0;
  std::vector<double> copy(values.begin(), values.end());
  const double place = q * static_cast<double>(copy.size() - 1);
  const auto below = copy.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(copy.begin(), below, copy.end());
  if (below + 1 == copy.end()) return *below;
  const double above = *std::min_element(below + 1, copy.end());
  return *below + (place - static_cast<double>(below - copy.begin())) * (above - *below);
}

double nearest_rank_quantile(std::span<const double> values, double q) {
  assert(q >= 0 && q <= 1);
  constexpr double rounding = 1e-9;  // 0.9 times 70 may be a little more than 63
  const auto count = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size()) - rounding));
  return value_of_rank(values, count > 0 ? count - 1 : 0);
}

double weighted_median(std::vector<Weighted> values) {
  const auto less = [](const Weighted& a, const Weighted& b) {
    return a.value != b.value ? a.value < b.value : a.weight < b.weight;
  };
  std::sort(values.begin(), values.end(), less);
  double all = 0, until = 0;
  for (const Weighted& one : values) all += one.weight;
  for (const Weighted& one : values) {
    until += one.weight;
    if (until >= 0.5 * all) return one.value;
  }
  return values.empty() ? 0.0 : values.back().value;
}

double theil_sen_gradient(std::span<const UncertainPoint> points) {
  constexpr std::size_t most_pairs = 200'000;
  std::vector<Weighted> gradients;
  const std::size_t n = points.size(), stride = 1 + n * n / 2 / most_pairs;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const double apart = points[j].x - points[i].x;
      if (apart == 0 || count++ % stride != 0) continue;
      const double sigma = std::hypot(points[i].sigma, points[j].sigma) / std::abs(apart);
      gradients.push_back({(points[j].y - points[i].y) / apart, 1.0 / sigma});
    }
  }
  return weighted_median(std::move(gradients));
}

double huber_weight(double residual) {
  constexpr double bend = 1.345;
  return residual > bend ? bend / residual : 1.0;
}

}  // namespace tactile
