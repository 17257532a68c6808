#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/model/definition/stream_options.hpp"

namespace tactile::model {

/// The rectangle of a sensor that is cut into cells. A cell has left + k (right - left) / columns <= x < the same of k + 1.
struct StreamGrid {
  double left = 0, top = 0, right = 0, bottom = 0;  ///< [px]

  friend bool operator==(const StreamGrid&, const StreamGrid&) = default;
};

/// @throws Error  unless the rectangle has an area, and lies within 32767 px of 0
void check(const StreamGrid& grid);

/// The rectangle that holds all but `outside` of the events on each side, so that the places lie where a skin's marks move.
/// @param columns, rows  events of each column and row of pixels
/// @return  the whole sensor if there are no events
StreamGrid grid_around(std::span<const std::uint64_t> columns, std::span<const std::uint64_t> rows, double outside = 0.01);

/// The events of one tick, counted by cell. Costs a few ns for each event, and nothing for cells without events.
class StreamCounts {
 public:
  /// @throws Error  if the sensor has no area, or as `check`
  StreamCounts(events::SensorSize sensor, const StreamGrid& grid);

  void count(const events::Event& event);  ///< of the sensor; one outside the grid does not count
  void clear();

  std::span<const std::uint16_t> touched() const { return {touched_.data(), touched_count_}; }  ///< cells with events, each once
  std::uint32_t at(std::size_t cell) const { return counts_[cell]; }

 private:
  static constexpr std::uint32_t outside = StreamLayout::cells;  ///< as a part of a cell's number

  std::vector<std::uint32_t> column_of_, row_of_;  ///< the cell of a pixel is the sum of both, and of its polarity's
  std::array<std::uint32_t, StreamLayout::cells> counts_{};
  std::array<std::uint16_t, StreamLayout::cells> touched_{};
  std::size_t touched_count_ = 0;
};

}  // namespace tactile::model
