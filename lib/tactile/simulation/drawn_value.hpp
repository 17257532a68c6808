#pragma once

#include <algorithm>
#include <cmath>

#include "tactile/core/random.hpp"

namespace tactile {

/// A range that a run's value is drawn from, every value alike.
struct Range {
  double low = 0;
  double high = 0;
};

inline double drawn(const Range& range, Random& random) { return random.uniform(range.low, range.high); }

/// Round `typical`, by a factor whose logarithm is normal with this spread, cut at two spreads.
inline double varied(double typical, double spread, Random& random) {
  return typical * std::exp(spread * std::clamp(random.normal(), -2.0, 2.0));
}

/// Normal round 0, cut at 2.5 sigma.
inline double cut_normal(double sigma, Random& random) { return sigma * std::clamp(random.normal(), -2.5, 2.5); }

}  // namespace tactile
