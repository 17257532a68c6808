#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "tactile/results/figure.hpp"

namespace tactile::results {

/// How far a figure moves if onsets and ends are drawn from their 95 % intervals.
struct SpreadByLabels {
  double mean = std::numeric_limits<double>::quiet_NaN();  ///< over the draws, of the same runs; NaN where there is none
  double low = std::numeric_limits<double>::quiet_NaN();   ///< the middle 95 % of the draws
  double high = std::numeric_limits<double>::quiet_NaN();
  Figure with_runs{};  ///< the figure by the labels as they are; its interval has the spread of the draws, too
};

/// {"mean", "low", "high", "with_runs"}
void to_json(nlohmann::json& json, const SpreadByLabels& spread);
void from_json(const JsonView& json, SpreadByLabels& spread);

struct LabelUncertainty {
  std::uint64_t draws = 0;                         ///< of all labels; 0: not drawn
  SpreadByLabels accuracy;                         ///< mean over objects
  SpreadByLabels press_mean_ms, slip_mean_ms;      ///< over detected intervals
  SpreadByLabels press_median_ms, slip_median_ms;  ///< over all intervals, as `DelaySummary::median_of_all_ms`
};

/// {"draws", "accuracy", "delay_ms": {"press": {"mean", "median_of_all"}, "slip"}}
void to_json(nlohmann::json& json, const LabelUncertainty& uncertainty);
void from_json(const JsonView& json, LabelUncertainty& uncertainty);

}  // namespace tactile::results
