#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// A quantile of delays of all intervals, where a missed interval counts with the time until which it could be detected.
struct CensoredQuantile {
  Figure ms{};
  bool is_lower_bound = false;  ///< fewer intervals than the quantile needs are detected within it: the true one is longer
};

/// {"value", "low", "high", "n", "trainings", "is_lower_bound"}
void to_json(nlohmann::json& json, const CensoredQuantile& quantile);
void from_json(const JsonView& json, CensoredQuantile& quantile);

/// Delays of one class over runs. Missed and early intervals are counted, never averaged in; quantiles of all include them.
struct DelaySummary {
  Figure mean_ms{};
  /// Standard deviation / sqrt(number of delays), the mean over trainings; NaN for fewer than two. It leaves out what the runs of
  /// an object, or its trainings, have in common, and so is narrower than the interval.
  double sem_ms = std::numeric_limits<double>::quiet_NaN();
  Figure median_ms{};
  std::uint64_t intervals = 0, misses = 0, early = 0;
  std::uint64_t head_starts = 0;          ///< detected ones that were predicted just before the onset
  Figure missed{};                        ///< share of misses, in [0, 1]
  CensoredQuantile median_of_all_ms{};    ///< early ones and head starts count 0
  CensoredQuantile quantile_of_all_ms{};  ///< 90 % of all intervals are detected within it

  double missed_share() const;  ///< of intervals missed or early, in [0, 1]; NaN without intervals
};

/// A point of the curve of detections.
struct DetectedWithin {
  double ms = 0;   ///< after the onset; 0: predicted ahead of it
  Figure share{};  ///< of intervals detected by then, in [0, 1], by Kaplan and Meier
};

/// {"ms", "share"}
void to_json(nlohmann::json& json, const DetectedWithin& point);
void from_json(const JsonView& json, DetectedWithin& point);

/// Over all runs, and of each object.
struct DelayTable {
  DelaySummary all{};                             ///< objects drawn first, then runs
  std::map<std::string, DelaySummary> objects{};  ///< runs drawn
  std::vector<DetectedWithin> curve{};            ///< over all runs, ascending in time; empty in older files
};

/// {"mean", "sem", "median", "intervals", "misses", "early", "head_starts", "missed", "median_of_all", "p90_of_all"}; and
/// "objects" and "detected_within" in a table.
void to_json(nlohmann::json& json, const DelaySummary& summary);
void to_json(nlohmann::json& json, const DelayTable& table);
void from_json(const JsonView& json, DelaySummary& summary);
void from_json(const JsonView& json, DelayTable& table);

}  // namespace tactile::results
