#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// A quantile of delays of all touches. One that is not detected is later than all others; where the quantile falls on one, the
/// value is the longest time in which one could be detected, or was.
struct CensoredQuantile {
  Figure ms{};
  bool is_lower_bound = false;  ///< fewer touches than the quantile needs are detected: it is longer than `ms`
};

/// The quantile; nothing where only a bound is known.
inline Figure measured(const CensoredQuantile& quantile) { return quantile.is_lower_bound ? Figure{} : quantile.ms; }

/// {"value", "low", "high", "n", "trainings", "is_lower_bound"}
void to_json(nlohmann::json& json, const CensoredQuantile& quantile);
void from_json(const JsonView& json, CensoredQuantile& quantile);

/// Delays of one class over runs. Missed and early touches are counted, never averaged in; quantiles of all include them.
struct DelaySummary {
  Figure mean_ms{};
  /// Standard deviation / sqrt(number of delays), the mean over trainings; NaN for fewer than two. It leaves out what the runs of
  /// an object, or its trainings, have in common, and so is narrower than the interval.
  double sem_ms = std::numeric_limits<double>::quiet_NaN();
  Figure median_ms{};
  std::uint64_t intervals = 0, misses = 0, early = 0;
  Figure missed{};                        ///< share of misses, in [0, 1]
  CensoredQuantile median_of_all_ms{};    ///< one that is not detected is later than all others
  CensoredQuantile quantile_of_all_ms{};  ///< 90 % of all touches are detected within it
};

template <class Members>
void list_members(Members& members, DelaySummary& summary) {
  members("mean", summary.mean_ms);
  members("sem", summary.sem_ms);
  members("median", summary.median_ms);
  members("intervals", summary.intervals);
  members("misses", summary.misses);
  members("early", summary.early);
  members("missed", summary.missed);
  members("median_of_all", summary.median_of_all_ms);
  members("p90_of_all", summary.quantile_of_all_ms);
}

/// Over all runs, and of each object.
struct DelayTable {
  DelaySummary all{};
  std::map<std::string, DelaySummary> objects{};
};

template <class Members>
void list_members(Members& members, DelayTable& table) {
  list_members(members, table.all);
  members("objects", table.objects);
}

}  // namespace tactile::results
