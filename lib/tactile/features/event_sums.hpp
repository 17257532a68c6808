#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactile::features {

/// The grid that events are counted in: columns and rows of equal parts of the sensor, whatever its size.
inline constexpr std::size_t grid_columns = 24, grid_rows = 18, grid_cells = grid_columns * grid_rows;

/// Sums over the events of a time window, of each polarity: [0] darker, [1] brighter. They are whole numbers: a sum does not
/// depend on the order of the events, and nothing is lost however long a recording is. An overflow takes 2^32 events in a window.
struct EventSums {
  struct OfPolarity {
    std::uint64_t events = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;  ///< number, and sums of x, y, x^2, y^2, x y [px, px^2]

    friend bool operator==(const OfPolarity&, const OfPolarity&) = default;
  };
  std::array<OfPolarity, 2> of{};
  std::array<std::array<std::uint32_t, grid_cells>, 2> cells{};  ///< events in each cell, row by row

  EventSums& operator+=(const EventSums& other) {
    for (std::size_t polarity = 0; polarity < of.size(); ++polarity) {
      OfPolarity& sums = of[polarity];
      const OfPolarity& more = other.of[polarity];
      sums.events += more.events, sums.x += more.x, sums.y += more.y;
      sums.xx += more.xx, sums.yy += more.yy, sums.xy += more.xy;
      for (std::size_t cell = 0; cell < grid_cells; ++cell) cells[polarity][cell] += other.cells[polarity][cell];
    }
    return *this;
  }

  friend bool operator==(const EventSums&, const EventSums&) = default;
};

}  // namespace tactile::features
