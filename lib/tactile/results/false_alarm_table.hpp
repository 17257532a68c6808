#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Episodes of one run that began without a touch, and the time without a touch.
struct FalseAlarms {
  std::uint64_t alarms = 0;           ///< false alarms proper
  std::uint64_t after_intervals = 0;  ///< begun within the guard after an interval
  std::uint64_t releases = 0;         ///< begun in a release that `label` found, or within the guard after it
  std::uint64_t unlabelled = 0;       ///< begun in unlabelled motion
  microseconds none_time{0};          ///< ticks in no interval or release, not within the guard after one, and in no unlabelled
                                      ///< interval
  microseconds after_intervals_time{0};
  microseconds releases_time{0};
  microseconds unlabelled_time{0};

  FalseAlarms& operator+=(const FalseAlarms& other);

  std::optional<double> per_min() const;  ///< of none time; nothing where there was none
};

/// Per minute of none time, over all runs and of each object; intervals widened by few alarms.
struct FalseAlarmTable {
  Figure per_min;                         ///< all alarms / all none time; objects drawn first, then runs
  std::map<std::string, Figure> objects;  ///< runs drawn
  FalseAlarms total;
};

/// {"count", "none_min", "per_min", "objects", "after_intervals": {"count", "min"}, "releases": {"count", "min"}, "unlabelled":
/// {"count", "min"}}
void to_json(nlohmann::json& json, const FalseAlarmTable& table);
void from_json(const JsonView& json, FalseAlarmTable& table);

double in_minutes(microseconds time);

}  // namespace tactile::results
