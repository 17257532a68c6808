#include "tactile/heatmaps/byte_blocks.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tactile::heatmaps {
namespace {

constexpr std::uint32_t many = CellCounts<std::uint8_t>::many;
constexpr std::uint32_t block_cells = CellCounts<std::uint8_t>::block_cells;

/// The types of a cell's sum: for one-byte numbers 28 bits and float32 are enough.
template <class Number>
using SumFor = std::conditional_t<sizeof(Number) == 1, std::int32_t, std::int64_t>;
template <class Number>
using RealFor = std::conditional_t<sizeof(Number) == 1, float, double>;

// Highway 1.0.3, that of Debian 12, has no product of bytes that adds neighbours (_mm256_maddubs_epi16), on which the sums rest.
#if defined(__x86_64__)
constexpr std::uint32_t planes = CellCounts<std::uint8_t>::planes;
constexpr int digits = 3;  // a weight is split into digits of 7 bits

struct WideScales {
  __m256i weights[planes][digits];  // of the four classes of a plane, repeated for each cell
  const float* row;
  const float* column;
};

__attribute__((target("avx2"))) inline void set_weights(WideScales& scales, const WholeWeights& weights) {
  static_assert(whole_weight(1.0) < 1 << 7 * digits && block_cells == 16);
  for (std::size_t plane = 0; plane < planes; ++plane) {
    for (int digit = 0; digit < digits; ++digit) {
      std::int32_t four = 0;
      for (std::size_t i = 0; i < 4; ++i) four |= (weights[4 * plane + i] >> 7 * digit & 127) << 8 * i;
      scales.weights[plane][digit] = _mm256_set1_epi32(four);
    }
  }
}

__attribute__((target("avx2"), always_inline)) inline __m256i load(const std::uint8_t* numbers) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(numbers));
}

/// The sums of eight cells, from their numbers in the first `used` planes. 16 bits do not overflow: a cell has at most 225 pixels
/// in all classes together.
template <std::size_t used>
__attribute__((target("avx2"), always_inline)) inline __m256i sums_of(const __m256i* numbers, const WideScales& scales) {
  __m256i sums = _mm256_setzero_si256();
  for (int digit = 0; digit < digits; ++digit) {
    __m256i of_digit = _mm256_maddubs_epi16(numbers[0], scales.weights[0][digit]);
    for (std::size_t plane = 1; plane < used; ++plane)
      of_digit = _mm256_add_epi16(of_digit, _mm256_maddubs_epi16(numbers[plane], scales.weights[plane][digit]));
    sums = _mm256_add_epi32(sums, _mm256_madd_epi16(of_digit, _mm256_set1_epi16(static_cast<std::int16_t>(1 << 7 * digit))));
  }
  return sums;
}

__attribute__((target("avx2"), always_inline)) inline void put_bytes(__m256i left_sums, __m256i right_sums,
                                                                     const WideScales& scales,
                                                                     const CellCounts<std::uint8_t>::Block& block, int width,
                                                                     std::uint8_t* heatmap) {
  const float* const column = scales.column + block.column;
  const __m256 row = _mm256_set1_ps(scales.row[block.row]), halves = _mm256_set1_ps(static_cast<float>(byte_half));
  const __m256 left_scale = _mm256_mul_ps(_mm256_loadu_ps(column), row);
  const __m256 right_scale = _mm256_mul_ps(_mm256_loadu_ps(column + 8), row);
  const __m256i left = _mm256_cvttps_epi32(_mm256_add_ps(_mm256_mul_ps(_mm256_cvtepi32_ps(left_sums), left_scale), halves));
  const __m256i right = _mm256_cvttps_epi32(_mm256_add_ps(_mm256_mul_ps(_mm256_cvtepi32_ps(right_sums), right_scale), halves));
  const __m256i words = _mm256_permute4x64_epi64(_mm256_packs_epi32(left, right), 0b11'01'10'00);
  const __m128i bytes = _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
  std::uint8_t* const place = heatmap + block.heatmap_index;
  if (block.column + block_cells <= static_cast<std::uint32_t>(width)) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(place), bytes);
  } else {
    std::array<std::uint8_t, block_cells> part;
    _mm_storeu_si128(reinterpret_cast<__m128i*>(part.data()), bytes);
    std::memcpy(place, part.data(), static_cast<std::uint32_t>(width) - block.column);
  }
}

/// The same for sixteen cells at a time, with identical bits.
__attribute__((target("avx2"))) std::size_t byte_blocks_wide(CellCounts<std::uint8_t>& cells, const ByteScales& scales, int width,
                                                             std::span<std::uint8_t> heatmap,
                                                             std::span<std::uint32_t> with_many) {
  WideScales wide;
  set_weights(wide, scales.weights);
  wide.row = scales.row, wide.column = scales.column;
  const __m256i but_none = _mm256_set1_epi32(~255), only_many = _mm256_set1_epi32(255 << 24);
  std::size_t many_blocks = 0;
  for (std::uint32_t first = 0; first < cells.blocks().size(); first += cells.together) {
    auto [low, high] = cells.active_blocks(first);
    for (; low != 0; low &= low - 1) {
      const std::uint32_t index = first + static_cast<std::uint32_t>(std::countr_zero(low));
      const std::uint8_t* const numbers = cells.numbers(index, 0);
      const __m256i left = load(numbers), right = load(numbers + 32);
      if (_mm256_testz_si256(_mm256_or_si256(left, right), but_none) != 0) {
        cells.set_empty(index);
        continue;
      }
      put_bytes(sums_of<1>(&left, wide), sums_of<1>(&right, wide), wide, cells.blocks()[index], width, heatmap.data());
    }
    for (; high != 0; high &= high - 1) {
      const std::uint32_t index = first + static_cast<std::uint32_t>(std::countr_zero(high));
      __m256i left[planes], right[planes], above_low = _mm256_setzero_si256();
      for (std::uint32_t plane = 0; plane < planes; ++plane) {
        left[plane] = load(cells.numbers(index, plane)), right[plane] = load(cells.numbers(index, plane) + 32);
        if (plane > 0) above_low = _mm256_or_si256(above_low, _mm256_or_si256(left[plane], right[plane]));
      }
      if (_mm256_testz_si256(above_low, above_low) != 0) cells.set_low(index);
      with_many[many_blocks] = index;
      many_blocks += _mm256_testz_si256(_mm256_or_si256(left[planes - 1], right[planes - 1]), only_many) == 0 ? 1 : 0;
      put_bytes(sums_of<planes>(left, wide), sums_of<planes>(right, wide), wide, cells.blocks()[index], width, heatmap.data());
    }
  }
  return many_blocks;
}
#endif

}  // namespace

template <class Number>
std::size_t byte_blocks_plainly(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                                std::span<std::uint32_t> with_many) {
  std::size_t many_blocks = 0;
  for (std::uint32_t first = 0; first < cells.blocks().size(); first += cells.together) {
    const auto [low, high] = cells.active_blocks(first);
    for (std::uint64_t active = low | high; active != 0; active &= active - 1) {
      const std::uint32_t index = first + static_cast<std::uint32_t>(std::countr_zero(active));
      const auto& block = cells.blocks()[index];
      std::array<std::uint8_t, block_cells> bytes;
      std::array<Number, many + 1> any{};
      for (std::uint32_t lane = 0; lane < block_cells; ++lane) {
        SumFor<Number> sum = 0;
        for (std::uint32_t count = 1; count <= many; ++count) {
          const Number number = cells.number(index, lane, count);
          any[count] = static_cast<Number>(any[count] | number);
          sum += static_cast<SumFor<Number>>(number) * scales.weights[count];
        }
        using Real = RealFor<Number>;
        const Real scale = scales.column[block.column + lane] * scales.row[block.row];
        bytes[lane] = static_cast<std::uint8_t>(static_cast<int>(static_cast<Real>(sum) * scale + static_cast<Real>(byte_half)));
      }
      const auto is_zero = [](Number number) { return number == 0; };
      if (std::all_of(any.begin() + cells.low + 1, any.end(), is_zero))
        std::all_of(any.begin(), any.end(), is_zero) ? cells.set_empty(index) : cells.set_low(index);
      if (any[many] != 0) with_many[many_blocks++] = index;
      std::copy_n(bytes.data(), std::min(block_cells, static_cast<std::uint32_t>(width) - block.column),
                  &heatmap[block.heatmap_index]);
    }
  }
  return many_blocks;
}

template <class Number>
std::size_t byte_blocks(CellCounts<Number>& cells, const ByteScales& scales, int width, std::span<std::uint8_t> heatmap,
                        std::span<std::uint32_t> with_many) {
#if defined(__x86_64__)
  if constexpr (sizeof(Number) == 1) {
    static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
    if (has_avx2) return byte_blocks_wide(cells, scales, width, heatmap, with_many);
  }
#endif
  return byte_blocks_plainly(cells, scales, width, heatmap, with_many);
}

template std::size_t byte_blocks(CellCounts<std::uint8_t>&, const ByteScales&, int, std::span<std::uint8_t>,
                                 std::span<std::uint32_t>);
template std::size_t byte_blocks(CellCounts<std::uint32_t>&, const ByteScales&, int, std::span<std::uint8_t>,
                                 std::span<std::uint32_t>);
template std::size_t byte_blocks_plainly(CellCounts<std::uint8_t>&, const ByteScales&, int, std::span<std::uint8_t>,
                                         std::span<std::uint32_t>);
template std::size_t byte_blocks_plainly(CellCounts<std::uint32_t>&, const ByteScales&, int, std::span<std::uint8_t>,
                                         std::span<std::uint32_t>);

}  // namespace tactile::heatmaps
