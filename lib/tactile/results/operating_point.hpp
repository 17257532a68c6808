#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

/// Delays and false alarms at one probability threshold of press and slip.
struct OperatingPoint {
  double threshold = std::numeric_limits<double>::quiet_NaN();  ///< in [0, 1]; NaN: the network's own verdicts, without one
  DelaySummary press{}, slip{};                                 ///< over all runs
  Figure false_alarms_per_min{};
  std::uint64_t false_alarms = 0;
  Figure outside_labels_per_min{};  ///< as `FalseAlarmTable` has it; nothing in older files
  Figure wrong_class_per_min{};
};

/// {"threshold", "delay_ms": {"press", "slip"}, "false_alarms_per_min", "false_alarms", "outside_labels_per_min",
/// "wrong_class_per_min"}
void to_json(nlohmann::json& json, const OperatingPoint& point);
void from_json(const JsonView& json, OperatingPoint& point);

}  // namespace tactile::results
