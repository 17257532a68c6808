#pragma once

#include <map>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::report {

// Results of each object. Values that are NaN are not drawn. Names that are too long lose their middle. A figure shows the first
// 60 objects and prints how many there are.

/// Accuracy of models of several histories on one object, or over all.
struct HistoryCurve {
  struct Point {
    double history_ms = 0;     ///< t_h
    results::Figure accuracy;  ///< in [0, 1]
  };
  std::string name;
  std::vector<Point> points;  ///< by history
};

/// The first greatest accuracy; the end where no point has a value.
std::vector<HistoryCurve::Point>::const_iterator best_of(const HistoryCurve& curve);

/// A small panel for each curve on common axes, with the other curves in grey; its best history is marked.
/// Source: Faris et al., arXiv:2403.10120, figure 8.
pictures::Plot accuracy_by_history_plot(const std::string& title, const std::vector<HistoryCurve>& curves);

/// Bars of the mean detection delay with its standard error, presses next to slips, one row for each object. Words next to the
/// bars count missed and early intervals.
/// @param objects   in the order of the rows
/// @param limit_ms  the paper's limit, drawn as a line
/// Source: Faris et al., arXiv:2403.10120, figure 9.
pictures::Plot delay_plot(const std::string& title, const std::vector<std::string>& objects,
                          const std::map<std::string, results::DelaySummary>& press,
                          const std::map<std::string, results::DelaySummary>& slip, double limit_ms = 5);

/// Accuracy on each object with it in training, and without, one row for each object.
/// Source: Faris et al., arXiv:2403.10120, figure 11.
pictures::Plot unseen_plot(const std::string& title, const std::map<std::string, results::SeenAndHeldOut>& objects);

}  // namespace tactile::report
