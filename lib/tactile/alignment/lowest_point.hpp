#pragma once

#include <cmath>
#include <limits>

namespace tactile::alignment {

struct LowestPoint {
  double at = 0, value = 0;
  double curvature = 0;  ///< second derivative there, from a thousandth on either side
};

/// The lowest point of `cost`, a function of one number [s], within `reach` of `middle`: the best of points `step` apart, then
/// between its neighbours by ternary search to a hundred-thousandth.
template <class Cost>
LowestPoint lowest_point(const Cost& cost, double middle, double reach, double step) {
  LowestPoint best{.at = middle, .value = std::numeric_limits<double>::infinity(), .curvature = 0};
  const auto steps = static_cast<int>(std::floor(2 * reach / step + 1e-6));
  for (int i = 0; i <= steps; ++i) {
    const double at = middle - reach + step * i, value = cost(at);
    if (value < best.value) best = {.at = at, .value = value, .curvature = 0};
  }
  double low = best.at - step, high = best.at + step;
  while (high - low > 1e-5) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (cost(a) < cost(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  best.at = 0.5 * (low + high);
  best.value = cost(best.at);
  constexpr double aside = 1e-3;
  best.curvature = (cost(best.at - aside) - 2 * best.value + cost(best.at + aside)) / (aside * aside);
  return best;
}

}  // namespace tactile::alignment
