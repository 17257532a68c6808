#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/operating_point.hpp"
#include "tactile/results/over_time.hpp"

namespace tactile {

// Results of predictions at every tick. Values that are NaN are not drawn.

/// Delay, and the share of intervals that it leaves out, against false alarms over the thresholds. Some thresholds are written
/// beside the points of each curve, in its colour, where there is room.
/// @param own  of the network's own verdicts, without a threshold: hollow diamonds
Plot operating_curve_plot(const std::string& title, const std::vector<OperatingPoint>& points,
                          const std::optional<OperatingPoint>& own = {});

/// The share of ticks of presses and slips that are predicted correctly: since the onset on the left, before the end on the
/// right.
Plot over_time_plot(const std::string& title, const AccuracyOverTime& press, const AccuracyOverTime& slip);

}  // namespace tactile
