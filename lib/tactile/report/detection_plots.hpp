#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::report {

// Results of predictions at every tick. Values that are NaN are not drawn.

/// Delay, and the share of touches that are not detected, against false alarms over the thresholds. Some thresholds are written
/// next to the points of the median, where there is room. Delays of more than 100 ms are drawn there.
/// @param own  of the verdicts as they were decided: hollow diamonds
pictures::Plot operating_curve_plot(const std::string& title, const std::vector<results::OperatingPoint>& points,
                                    const std::optional<results::OperatingPoint>& own = {});

/// One setting of a study.
struct SettingCurve {
  std::string name;
  bool is_stream = false, is_unseen = false;  ///< objects that were held out of training
  std::vector<results::OperatingPoint> points;
};

/// The delay of half of the touches, and of 90 %, against false alarms over the thresholds: a line for each setting.
pictures::Plot settings_curve_plot(const std::string& title, const std::vector<SettingCurve>& settings);

}  // namespace tactile::report
