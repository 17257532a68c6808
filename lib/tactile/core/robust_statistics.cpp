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

}  // namespace tactile
