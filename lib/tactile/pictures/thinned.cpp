#include "tactile/pictures/thinned.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tactile::pictures {
namespace {

/// Appends what is seen of points[first, last), which fall into one column.
void add_column(std::span<const PlotPoint> points, std::size_t first, std::size_t last, std::vector<PlotPoint>& seen) {
  std::optional<std::size_t> least, largest, gap, begin, end;
  for (std::size_t i = first; i < last; ++i) {
    if (std::isnan(points[i].y)) {
      gap = i;
      continue;
    }
    if (!begin) begin = i;
    end = i;
    if (!least || points[i].y < points[*least].y) least = i;
    if (!largest || points[i].y > points[*largest].y) largest = i;
  }
  std::vector<std::size_t> kept;
  for (const auto& index : {begin, least, largest, end, gap}) {
    if (index) kept.push_back(*index);
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  for (const std::size_t index : kept) seen.push_back(points[index]);
}

}  // namespace

std::vector<PlotPoint> thinned(std::span<const PlotPoint> points, double begin, double end, std::size_t columns) {
  const auto before = [](const PlotPoint& point, double x) { return point.x < x; };
  const auto index_of = [&](double x) {
    return static_cast<std::size_t>(std::lower_bound(points.begin(), points.end(), x, before) - points.begin());
  };
  const std::size_t first = index_of(begin), last = std::max(first, index_of(end));
  std::vector<PlotPoint> seen;
  if (first > 0) seen.push_back(points[first - 1]);
  const double width = (end - begin) / static_cast<double>(columns);
  for (std::size_t i = first; i < last;) {
    const double column_end = begin + (std::floor((points[i].x - begin) / width) + 1) * width;
    std::size_t next = i + 1;
    while (next < last && points[next].x < column_end) ++next;
    add_column(points, i, next, seen);
    i = next;
  }
  if (last < points.size()) seen.push_back(points[last]);
  return seen;
}

}  // namespace tactile::pictures
