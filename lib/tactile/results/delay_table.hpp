#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Delays of one class over runs; missed and early intervals are counted, never averaged in.
struct DelaySummary {
  Figure mean_ms{};
  double sem_ms =
      std::numeric_limits<double>::quiet_NaN();  ///< standard deviation / sqrt(number of delays); NaN for fewer than two
  Figure median_ms{};
  std::uint64_t intervals = 0, misses = 0, early = 0;

  double missed_share() const;  ///< of intervals missed or early, in [0, 1]; NaN without intervals
};

/// Over all runs, and of each object.
struct DelayTable {
  DelaySummary all{};                             ///< objects drawn first, then runs
  std::map<std::string, DelaySummary> objects{};  ///< runs drawn
};

/// {"mean", "sem", "median", "intervals", "misses", "early"}, and "objects" in a table.
void to_json(nlohmann::json& json, const DelaySummary& summary);
void to_json(nlohmann::json& json, const DelayTable& table);
void from_json(const JsonView& json, DelaySummary& summary);
void from_json(const JsonView& json, DelayTable& table);

}  // namespace tactile::results
