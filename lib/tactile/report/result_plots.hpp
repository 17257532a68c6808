#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/report/gnuplot.hpp"
#include "tactile/results/calibration.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"
#include "tactile/results/operating_point.hpp"
#include "tactile/results/over_time.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile {

// Figures of results. What is NaN is left out of a figure; names that are too long for their place lose their middle. A figure
// with more rows or panels than a page bears shows the first, and says so.

/// How accurate models of several histories are on one object, or over all.
struct HistoryCurve {
  struct Point {
    double history_ms = 0;  ///< t_h
    Figure accuracy;        ///< in [0, 1]
  };
  std::string name;
  std::vector<Point> points;  ///< by history
};

/// The first greatest accuracy; nothing but the end where no point has a value.
std::vector<HistoryCurve::Point>::const_iterator best_of(const HistoryCurve& curve);

/// A small panel for each curve on common axes, the others grey behind it; its best history is marked.
/// Source: Faris et al., arXiv:2403.10120, figure 6.
Plot accuracy_by_history_plot(const std::string& title, const std::vector<HistoryCurve>& curves);

/// Bars of the mean detection delay with its standard error, presses beside slips, an object a row; what was missed or early is
/// told beside them.
/// @param objects  in the order of the rows, those of `press` and `slip` that they name
/// @param limit_ms a line that the paper stays below
/// Source: Faris et al., arXiv:2403.10120, figure 7.
Plot delay_plot(const std::string& title, const std::vector<std::string>& objects,
                const std::map<std::string, DelaySummary>& press, const std::map<std::string, DelaySummary>& slip,
                double limit_ms = 5);

/// Accuracy on each object with it in training, and without, an object a row.
/// Source: Faris et al., arXiv:2403.10120, figure 9.
Plot unseen_plot(const std::string& title, const std::map<std::string, SeenAndHeldOut>& objects);

/// Rows true, columns said; each field with its count and its share of the row.
Plot confusion_plot(const std::string& title, const Confusion& confusion);

/// Delay, and what it leaves out, against false alarms over the thresholds. A few are told beside the points of each curve, in
/// its colour, where there is room.
/// @param own  what the network's own verdicts give, without a threshold: hollow diamonds
Plot operating_curve_plot(const std::string& title, const std::vector<OperatingPoint>& points,
                          const std::optional<OperatingPoint>& own = {});

inline constexpr std::uint64_t few_samples = 20;  ///< a bin with fewer is drawn hollow

Plot reliability_plot(const std::string& title, const std::vector<ReliabilityBin>& bins);

/// A training, epoch by epoch.
struct TrainingCurve {
  struct Epoch {
    double epoch = 0, loss = std::numeric_limits<double>::quiet_NaN();
    double accuracy = std::numeric_limits<double>::quiet_NaN();        ///< on the samples learned from, in [0, 1]
    double later_accuracy = std::numeric_limits<double>::quiet_NaN();  ///< on the validation part, where there is one
  };
  std::string name;
  std::vector<Epoch> epochs;
};

/// Loss and accuracy of each training; the first eight are named.
Plot training_plot(const std::string& title, const std::vector<TrainingCurve>& curves);

/// The share of ticks said right in presses and slips, since the onset on the left and before the end on the right.
Plot over_time_plot(const std::string& title, const AccuracyOverTime& press, const AccuracyOverTime& slip);

}  // namespace tactile
