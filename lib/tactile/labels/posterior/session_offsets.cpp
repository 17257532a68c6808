#include "tactile/labels/posterior/session_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace tactile::labels {
namespace {

constexpr std::size_t most_others = 12;
constexpr double drift_ppm = 60, drift_step_ppm = 30, least_likely = 8;
constexpr int drift_steps = 6;
constexpr std::int64_t step_us = 2'000;

/// Another run, seen from one.
struct Other {
  const std::vector<WeighedOffset>* offsets;
  double later_us;  ///< than the one
};

std::vector<Other> nearest_others(std::span<const OffsetsOfRun> runs, std::size_t of) {
  std::vector<Other> others;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (k == of || runs[k].offsets.empty()) continue;
    others.push_back({&runs[k].offsets, static_cast<double>(saturating_subtract(us_of(runs[k].at), us_of(runs[of].at)))});
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const Other& a, const Other& b) { return std::abs(a.later_us) < std::abs(b.later_us); });
  others.resize(std::min(others.size(), most_others));
  return others;
}

/// The offsets of a run that one of the others has, with one drift.
std::vector<std::int64_t> candidates(const std::vector<Other>& others, double drift) {
  std::vector<std::int64_t> found;
  for (const Other& other : others) {
    for (const WeighedOffset& one : *other.offsets) {
      if (one.log_weight < -least_likely) continue;
      const double here = static_cast<double>(one.us) - drift * other.later_us;
      found.push_back(std::llround(here / step_us) * step_us);
    }
  }
  return ascending(std::move(found));
}

std::vector<WeighedOffset> offsets_by(const std::vector<Other>& others) {
  std::map<std::int64_t, std::vector<double>> weights;
  for (int k = -drift_steps; k <= drift_steps; ++k) {
    const double drift = 1e-6 * drift_step_ppm * k, z = drift_step_ppm * k / drift_ppm;
    for (const std::int64_t us : candidates(others, drift)) {
      double weight = -0.5 * z * z;
      for (const Other& other : others) weight += log_density(*other.offsets, static_cast<double>(us) + drift * other.later_us);
      weights[us].push_back(weight);
    }
  }
  std::vector<WeighedOffset> offsets(weights.size());
  std::transform(weights.begin(), weights.end(), offsets.begin(), [](const auto& one) {
    return WeighedOffset{one.first, log_sum(one.second)};
  });
  normalise(offsets);
  std::erase_if(offsets, [](const WeighedOffset& one) { return one.log_weight < -least_likely; });
  normalise(offsets);
  return offsets;
}

}  // namespace

std::vector<std::vector<WeighedOffset>> offsets_by_others(std::span<const OffsetsOfRun> runs) {
  std::vector<std::vector<WeighedOffset>> of_runs(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<Other> others = nearest_others(runs, i);
    if (!others.empty()) of_runs[i] = offsets_by(others);
  }
  return of_runs;
}

}  // namespace tactile::labels
