#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/over_time.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::report {

// Results of predictions at every tick. Values that are NaN are not drawn.

/// The share of intervals detected by a time after their onset, with its interval as thin lines. Time is drawn on a scale of
/// log(1 + t / 2 ms), from those predicted ahead of the onset, at 0.
pictures::Plot detection_curve_plot(const std::string& title, const std::vector<results::DetectedWithin>& press,
                                    const std::vector<results::DetectedWithin>& slip);

/// Delay, and the share of touches that are not detected, against false alarms over the thresholds. Some thresholds are written
/// next to the points of the median, where there is room. Delays of more than 100 ms are drawn there.
/// @param own  of the verdicts as they were decided: hollow diamonds
pictures::Plot operating_curve_plot(const std::string& title, const std::vector<results::OperatingPoint>& points,
                                    const std::optional<results::OperatingPoint>& own = {});

/// The share of ticks of presses and slips that are predicted correctly: since the onset on the left, before the end on the
/// right.
pictures::Plot over_time_plot(const std::string& title, const results::AccuracyOverTime& press,
                              const results::AccuracyOverTime& slip);

}  // namespace tactile::report
