#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tactile/core/random.hpp"

namespace tactile::simulation {

/// A range from which a run's value is drawn uniformly.
struct Range {
  double low = 0;
  double high = 0;
};

/// Random numbers of a run that its object has in part in all its runs: the same grip by the same program.
class RepeatedRandom {
 public:
  /// @param object_seed  the same in all runs of an object
  /// @param new_share    of each spread, from 0 (all runs alike) to 1 (each run as if it were the only one)
  RepeatedRandom(std::uint64_t object_seed, double new_share, Random& run)
      : object_(object_seed), run_(run), new_share_(new_share), kept_share_(std::sqrt(1.0 - new_share * new_share)) {}

  double uniform(double low, double high) {
    const double object = object_.uniform(low, high), run = run_.uniform(low, high);
    return new_share_ * run + (1.0 - new_share_) * object;
  }
  /// Mean 0, standard deviation 1 over objects and runs.
  double normal() {
    const double object = object_.normal(), run = run_.normal();
    return new_share_ * run + kept_share_ * object;
  }
  Random& of_run() { return run_; }

 private:
  Random object_;
  Random& run_;
  double new_share_, kept_share_;
};

// `random` is a Random or a RepeatedRandom.

template <class Numbers>
double drawn(const Range& range, Numbers& random) {
  return random.uniform(range.low, range.high);
}

/// `typical` times a factor whose logarithm is normal with this spread, limited to two spreads.
template <class Numbers>
double varied(double typical, double spread, Numbers& random) {
  return typical * std::exp(spread * std::clamp(random.normal(), -2.0, 2.0));
}

/// Normal around 0, limited to 2.5 sigma.
template <class Numbers>
double cut_normal(double sigma, Numbers& random) {
  return sigma * std::clamp(random.normal(), -2.5, 2.5);
}

}  // namespace tactile::simulation
