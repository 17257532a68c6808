#include "tactile/model/inference/stream_counts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

/// The first pixel that leaves at least `outside` of the events before it, and one past the last that leaves as many.
std::pair<double, double> extent_of(std::span<const std::uint64_t> events, double outside) {
  const std::uint64_t all = std::accumulate(events.begin(), events.end(), std::uint64_t{0});
  const double least = outside * static_cast<double>(all);
  std::size_t first = 0, end = events.size();
  double sum = 0;
  while (first < events.size() && sum + static_cast<double>(events[first]) <= least) sum += static_cast<double>(events[first++]);
  sum = 0;
  while (end > first + 1 && sum + static_cast<double>(events[end - 1]) <= least) sum += static_cast<double>(events[--end]);
  if (all == 0) return {0, static_cast<double>(events.size())};
  return {static_cast<double>(first), static_cast<double>(end)};
}

}  // namespace

void check(const StreamGrid& grid) {
  const auto is_side = [](double low, double high) {
    return low >= -events::most_side && high <= 2.0 * events::most_side && low < high;  // false for NaN
  };
  if (is_side(grid.left, grid.right) && is_side(grid.top, grid.bottom)) return;
  throw Error(fmt::format("a grid from x {}, y {} to x {}, y {}; expected a rectangle of the sensor", grid.left, grid.top,
                          grid.right, grid.bottom));
}

StreamGrid grid_around(std::span<const std::uint64_t> columns, std::span<const std::uint64_t> rows, double outside) {
  const auto [left, right] = extent_of(columns, outside);
  const auto [top, bottom] = extent_of(rows, outside);
  return {left, top, right, bottom};
}

StreamCounts::StreamCounts(events::SensorSize sensor, const StreamGrid& grid) {
  if (sensor.width < 1 || sensor.height < 1 || std::max(sensor.width, sensor.height) > events::most_side)
    throw Error(fmt::format("a sensor of {} x {} px; expected sides of 1 to {}", sensor.width, sensor.height, events::most_side));
  check(grid);
  const auto parts_of = [](int pixels, double low, double high, std::size_t parts, auto part_of) {
    std::vector<std::uint32_t> of(static_cast<std::size_t>(pixels), outside);
    for (std::size_t i = 0; i < of.size(); ++i) {
      const double k = std::floor((static_cast<double>(i) - low) / (high - low) * static_cast<double>(parts));
      if (k >= 0 && k < static_cast<double>(parts)) of[i] = static_cast<std::uint32_t>(part_of(static_cast<std::size_t>(k)));
    }
    return of;
  };
  column_of_ = parts_of(sensor.width, grid.left, grid.right, StreamLayout::all_columns,
                        [](std::size_t column) { return StreamLayout::cell(0, 0, column); });
  row_of_ = parts_of(sensor.height, grid.top, grid.bottom, StreamLayout::all_rows,
                     [](std::size_t row) { return StreamLayout::cell(0, row, 0); });
}

void StreamCounts::count(const events::Event& event) {
  const std::uint32_t place = column_of_[static_cast<std::size_t>(event.x)] + row_of_[static_cast<std::size_t>(event.y)];
  const std::size_t cell = place + (event.on != 0 ? StreamLayout::rows * StreamLayout::columns : 0);
  if (place >= outside) return;
  if (counts_[cell]++ == 0) touched_[touched_count_++] = static_cast<std::uint16_t>(cell);
}

void StreamCounts::clear() {
  for (const std::uint16_t cell : touched()) counts_[cell] = 0;
  touched_count_ = 0;
}

}  // namespace tactile::model
