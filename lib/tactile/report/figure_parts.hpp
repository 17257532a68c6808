#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tactile/pictures/plot_script.hpp"
#include "tactile/report/axis_tics.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::report {

// What several figures of results share.

/// Of every figure [px]: its words can be read where a phone shows it a little over half as wide.
inline constexpr int page_width = 600;
inline constexpr std::size_t most_panels = 60;  // of small panels, and of rows

inline double percent(double share) { return 100 * share; }

/// An axis of accuracy in percent. It ends at 100 and begins at the greatest whole ten below all values, at most 90.
class AccuracyAxis {
 public:
  void include(const results::Figure& accuracy);
  double begin() const;
  double end() const { return 100 + 0.03 * (100 - begin()); }

 private:
  double least_ = 100;
};

/// Counts values and intervals, for the key of the intervals.
class Whiskers {
 public:
  void include(const results::Figure& measured);
  /// An entry where there are intervals; a note where there are none.
  void explain(pictures::PlotHead& head) const;
  bool any() const { return intervals_ > 0; }

 private:
  std::size_t values_ = 0, intervals_ = 0;
};

/// In a key, the mark alone.
pictures::LineStyle mark_of(pictures::LineStyle style);

/// Appends both ends of the interval in percent; twice the value where there is no interval, since gnuplot leaves out a point
/// with a gap.
void add_interval(std::vector<double>& values, const results::Figure& measured);

/// "The first 60 of 100 are shown. "; empty where all are.
std::string first_of(std::size_t there, std::size_t shown);

/// Marks where intervals leave the panel: triangles at its border that point outwards.
/// @param rows   place, value, low and high of each interval, as a series of bars has them
/// @param range  of the upright axis
std::vector<pictures::PlotSeries> border_marks(pictures::PlotScript& script, const std::vector<double>& rows,
                                               const AxisRange& range, const pictures::LineStyle& style);

/// Names of rows as tics of the y axis, the first on top.
std::string row_names(const std::vector<std::string>& names);

}  // namespace tactile::report
