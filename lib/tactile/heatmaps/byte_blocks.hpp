#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tactile/heatmaps/cell_counts.hpp"

namespace tactile {

/// What each class of counts weighs, that of 0 and that of `many` nothing, in whole parts of the largest weight, so that sums are
/// exact, whatever the order. That moves a byte's value by 1.2e-4 at most; doing the rest in float32 by 7e-5 more.
using WholeWeights = std::array<std::int32_t, CellCounts<std::uint8_t>::many + 1>;

/// @param share  of the largest weight, in [0, 1]
constexpr std::int32_t whole_weight(double share) {
  constexpr double half = 0.5;
  return static_cast<std::int32_t>(share * (1 << 20) + half);
}

/// Added before a byte's value is cut off. What lies less than the error above below a half counts as a half.
constexpr double byte_half = 0.5 + 2.5e-4;

struct ByteScales {
  const WholeWeights& weights;
  const float* row;     ///< of each row of cells: a whole weight's part of 255 / a cell's pixels down
  const float* column;  ///< of each column: 1 / a cell's pixels across; filled up to whole blocks
};

/// Writes the bytes of all active blocks, of their pixels with fewer than `many` events:
///
///   byte = round(row * column * sum over counts of weight * number of pixels with the count)
///
/// @param width      of the heatmap
/// @param with_many  as long as there are blocks; takes the indexes of those that have pixels with `many` events
/// @return           how many it took
template <class Number>
std::size_t byte_blocks(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                        std::span<std::uint32_t> with_many);

/// The same, to the same bits, as any processor can.
template <class Number>
std::size_t byte_blocks_plainly(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                                std::span<std::uint32_t> with_many);

}  // namespace tactile
