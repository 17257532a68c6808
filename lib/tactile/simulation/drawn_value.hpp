#pragma once

#include <algorithm>
#include <cmath>

#include "tactile/core/random.hpp"

namespace tactile::simulation {

/// A range from which a run's value is drawn uniformly.
struct Range {
  double low = 0;
  double high = 0;
};

inline double drawn(const Range& range, Random& random) { return random.uniform(range.low, range.high); }

/// `typical` times a factor whose logarithm is normal with this spread, limited to two spreads.
inline double varied(double typical, double spread, Random& random) {
  return typical * std::exp(spread * std::clamp(random.normal(), -2.0, 2.0));
}

/// Normal around 0, limited to 2.5 sigma.
inline double cut_normal(double sigma, Random& random) { return sigma * std::clamp(random.normal(), -2.5, 2.5); }

}  // namespace tactile::simulation
