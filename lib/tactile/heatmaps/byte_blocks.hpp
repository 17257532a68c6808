#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tactile/heatmaps/cell_counts.hpp"

namespace tactile::heatmaps {

/// The weight of each class of counts, as a whole number of parts of the largest weight; 0 for the classes 0 and `many`. Sums are
/// therefore exact in any order. The rounding changes a byte's value by at most 1.2e-4, float32 by at most 7e-5 more.
using WholeWeights = std::array<std::int32_t, CellCounts<std::uint8_t>::many + 1>;

/// @param share  of the largest weight, in [0, 1]
constexpr std::int32_t whole_weight(double share) {
  constexpr double half = 0.5;
  return static_cast<std::int32_t>(share * (1 << 20) + half);
}

/// Added before a byte's value is truncated. A value that is below a half by less than the error above is rounded up.
constexpr double byte_half = 0.5 + 2.5e-4;

struct ByteScales {
  const WholeWeights& weights;
  const float* row;     ///< of each row of cells: 255 / (pixels of a cell in y * largest whole weight)
  const float* column;  ///< of each column: 1 / pixels of a cell in x; padded to whole blocks
};

/// Writes the bytes of all active blocks, from their pixels with fewer than `many` events:
///
///   byte = round(row * column * sum over counts of weight * number of pixels with the count)
///
/// @param width      of the heatmap
/// @param with_many  as long as the number of blocks; receives the indexes of those that have pixels with `many` events
/// @return           the number of these indexes
template <class Number>
std::size_t byte_blocks(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                        std::span<std::uint32_t> with_many);

/// The same with identical bits, for any processor.
template <class Number>
std::size_t byte_blocks_plainly(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                                std::span<std::uint32_t> with_many);

}  // namespace tactile::heatmaps
