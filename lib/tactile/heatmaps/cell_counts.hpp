#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::heatmaps {

/// The pixels of each cell of a heatmap: of the `step` x `step` pixels that it covers, `read` x `read` from `first` on, as far as
/// the sensor has them.
struct CellGrid {
  events::SensorSize sensor;
  events::SensorSize cells;
  int step = 1;
  int first = 0;
  int read = 1;
};

/// For each cell, the number of its pixels with 1, 2, ... 14 events, and with more. They are updated while single counts change
/// by one. So the weight of a count may change with every tick, and a cell's value still needs no access to its pixels, except
/// for those with `many` events.
///
/// @tparam Number  large enough for the number of pixels of a cell
template <class Number>
class CellCounts {
 public:
  static constexpr std::uint32_t many = 15;         ///< counts from here on form one class; each count below is a class
  static constexpr std::uint32_t block_cells = 16;  ///< adjacent cells with contiguous numbers
  /// Classes with contiguous numbers: 0 to 3, 4 to 7, 8 to 11, 12 to `many`. Most blocks have events only in the first plane.
  static constexpr std::uint32_t plane_classes = 4;
  static constexpr std::uint32_t count_limit = 2048;  ///< counts from here on are not tracked; they are all of one class
  static constexpr std::uint32_t planes = (many + 1) / plane_classes;
  static constexpr std::uint32_t block_length = block_cells * plane_classes;

  struct Block {
    std::uint32_t heatmap_index;  ///< of its first cell
    std::uint32_t row;            ///< its cells' y
    std::uint32_t column;         ///< its first cell's x
  };

  explicit CellCounts(const CellGrid& grid) {
    const auto width = static_cast<std::uint32_t>(grid.cells.width), height = static_cast<std::uint32_t>(grid.cells.height);
    for (std::uint32_t row = 0; row < height; ++row) {
      for (std::uint32_t column = 0; column < width; column += block_cells)
        blocks_.push_back({row * width + column, row, column});
    }
    const std::uint32_t blocks_across = (width + block_cells - 1) / block_cells;
    const std::uint32_t whole_groups = (static_cast<std::uint32_t>(blocks_.size()) + together - 1) / together * together;
    nowhere_ = whole_groups * block_length;
    plane_length_ = nowhere_ + block_length;
    pixels_with_.resize(std::size_t{planes} * plane_length_);
    for (std::uint32_t count = 0; count < offset_of_count_.size(); ++count)
      offset_of_count_[count] = offset_of(count, plane_length_);
    highest_.resize(whole_groups + 1);
    place_of_x_ = places(grid.sensor.width, grid.cells.width, grid, [](std::uint32_t cell) {
      return cell / block_cells * block_length + cell % block_cells * plane_classes;
    });
    place_of_y_ = places(grid.sensor.height, grid.cells.height, grid,
                         [&](std::uint32_t cell) { return cell * blocks_across * block_length; });
  }

  /// The start of the numbers of the pixel's cell, in each plane.
  std::uint32_t place_of(int x, int y) const {
    return std::min(place_of_x_[static_cast<std::size_t>(x)] + place_of_y_[static_cast<std::size_t>(y)], nowhere_);
  }

  /// Changes single counts. It copies the pointers, so that the compiler knows that they are constant.
  class Change {
   public:
    explicit Change(CellCounts& cells)
        : pixels_with_(cells.pixels_with_.data()),
          highest_(cells.highest_.data()),
          offset_of_count_(cells.offset_of_count_.data()) {}

    /// @param place     of the pixel's cell
    /// @param from, to  counts below `count_limit`; the number of pixels without events is not used, and may wrap
    void operator()(std::uint32_t place, std::uint32_t from, std::uint32_t to) const {
      --pixels_with_[place + offset_of_count_[from]];
      ++pixels_with_[place + offset_of_count_[to]];
      if (to > highest_[place / block_length]) highest_[place / block_length] = static_cast<std::uint8_t>(std::min(to, 255U));
    }

   private:
    Number* pixels_with_;
    std::uint8_t* highest_;
    const std::uint32_t* offset_of_count_;
  };

  std::span<const Block> blocks() const { return blocks_; }

  /// A bit for each of 64 blocks from `first` on: blocks whose pixels have at most `low` events, and the others with events. A
  /// block that has lost its events stays marked until `set_low` or `set_empty`.
  struct Active {
    std::uint64_t low, high;
  };
  static constexpr std::uint8_t low = plane_classes - 1;
  static constexpr std::uint32_t together = 64;

  /// @param first  a multiple of `together`, below the number of blocks
  Active active_blocks(std::uint32_t first) const {
    Active active{};
    for (std::uint32_t i = 0; i < together; i += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, &highest_[first + i], sizeof(eight));
      active.low |= bits_above(eight, 0) << i;
      active.high |= bits_above(eight, low) << i;
    }
    active.low &= ~active.high;
    return active;
  }
  void set_empty(std::uint32_t block) { highest_[block] = 0; }
  void set_low(std::uint32_t block) { highest_[block] = low; }

  /// The numbers of a block's cells, cell after cell, of the classes of one plane.
  const Number* numbers(std::uint32_t block, std::uint32_t plane) const {
    return &pixels_with_[std::size_t{plane} * plane_length_ + std::size_t{block} * block_length];
  }
  Number number(std::uint32_t block, std::uint32_t lane, std::uint32_t count_class) const {
    return numbers(block, count_class / plane_classes)[lane * plane_classes + count_class % plane_classes];
  }

 private:
  /// A bit for each of eight bytes: whether it is above a limit, which must be below 128.
  static std::uint64_t bits_above(std::uint64_t eight, std::uint64_t limit) {
    constexpr std::uint64_t each = 0x0101010101010101, top = 0x80 * each;
    const std::uint64_t above = (((eight & ~top) + (127 - limit) * each) | eight) & top;
    return (above >> 7) * 0x0102040810204080 >> 56;
  }

  static std::uint32_t offset_of(std::uint32_t count, std::uint32_t plane_length) {
    const std::uint32_t count_class = std::min(count, many);
    return count_class / plane_classes * plane_length + count_class % plane_classes;
  }

  template <class PlaceOf>
  std::vector<std::uint32_t> places(int pixels, int cells, const CellGrid& grid, PlaceOf place_of) const {
    std::vector<std::uint32_t> places(static_cast<std::size_t>(pixels), nowhere_);
    for (int i = 0; i < pixels && i / grid.step < cells; ++i) {
      const int within = i % grid.step;
      if (within >= grid.first && within < grid.first + grid.read)
        places[static_cast<std::size_t>(i)] = place_of(static_cast<std::uint32_t>(i / grid.step));
    }
    return places;
  }

  std::vector<Block> blocks_;  // row by row
  std::uint32_t nowhere_ = 0;  // the place of pixels outside all cells: an extra block after all others
  std::uint32_t plane_length_ = 0;
  std::array<std::uint32_t, count_limit> offset_of_count_{};
  std::vector<Number> pixels_with_;                     // [planes, blocks up to `nowhere_`'s, block_cells, plane_classes]
  std::vector<std::uint8_t> highest_;                   // highest count in a block, up to 255; may be outdated
  std::vector<std::uint32_t> place_of_x_, place_of_y_;  // their sum is the place of a cell's numbers
};

}  // namespace tactile::heatmaps
