#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tactile::pictures {

struct PlotPoint {
  double x = 0;
  double y = 0;  ///< NaN is a gap

  friend bool operator==(const PlotPoint&, const PlotPoint&) = default;
};

/// The visible points of a line where [begin, end) is this many pixels wide: of each column its first, least, largest
/// and last point, and a gap if it has one. The nearest points before and after stay, so that the line reaches both edges.
///
/// @param points   by x
/// @param columns  > 0
/// @return         by x; at most 5 points for each column, and two
/// Source: Jugel et al., M4: A Visualization-Oriented Time Series Data Aggregation, VLDB 2014.
std::vector<PlotPoint> thinned(std::span<const PlotPoint> points, double begin, double end, std::size_t columns);

}  // namespace tactile::pictures
