// The forward pass of FusedConvolutions. No #pragma once: fused_convolutions.cpp reads this file for each set of vector
// instructions.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "tactile/model/training/fused_convolutions.hpp"

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Kept = FusedConvolutions::Kept;
using Packed = FusedConvolutions::Packed;
using Workspace = FusedConvolutions::Workspace;
using Gradients = FusedConvolutions::Gradients;

constexpr std::size_t kernel = 5, first_channels = 6, second_channels = 16;
constexpr std::size_t lanes_of_first = 8;  // its 6 channels and two that are 0
constexpr std::size_t margin = 4;          // columns left of a strip, where a kernel hangs over
constexpr std::size_t row_of_second = 30;  // floats of the second layer's kernel that lie in a row: 5 places of 6 channels
constexpr std::size_t padded_row = 32;     // with two that are 0
constexpr std::uint8_t cut_off = 4;        // in place of which is the largest: ReLU lets none of them through

using Eight = hn::CappedTag<float, 8>;
using Sixteen = hn::CappedTag<float, 16>;
constexpr std::size_t eight_lanes = hn::MaxLanes(Eight()), sixteen_lanes = hn::MaxLanes(Sixteen());
constexpr std::size_t vectors_of_first = lanes_of_first / eight_lanes;

std::size_t strip_columns(const LeNetLayers& layers) { return static_cast<std::size_t>(layers.input.width) + margin; }

/// The cells that are not 0, row by row.
void find_cells(const LeNetLayers& layers, const std::uint8_t* heatmap, Workspace& work) {
  const auto width = static_cast<std::size_t>(layers.input.width), height = static_cast<std::size_t>(layers.input.height);
  static const std::array<float, 256> value_of = [] {
    std::array<float, 256> values;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i) / 255.0F;
    return values;
  }();
  std::uint32_t count = 0;
  for (std::size_t y = 0; y < height; ++y) {
    work.row_begin[y] = count;
    const std::uint8_t* row = heatmap + y * width;
    const auto take = [&](std::size_t begin, std::size_t end) {
      for (std::size_t x = begin; x < end; ++x) {
        work.cell_x[count] = static_cast<std::uint16_t>(x);
        work.cell_value[count] = value_of[row[x]];
        count += row[x] != 0 ? 1 : 0;
      }
    };
    std::size_t x = 0;
    for (; x + 8 <= width; x += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, row + x, 8);
      if (eight != 0) take(x, x + 8);
    }
    take(x, width);
  }
  work.row_begin[height] = count;
}

/// The larger of what was the largest and a value, and which that is. NaN stays, so that it is seen at the network's end.
template <class D, class V = hn::Vec<D>, class I = hn::Vec<hn::RebindToSigned<D>>>
HWY_INLINE void take_larger(D, V& best, I& which, V value, int place) {
  const hn::RebindToSigned<D> whole;
  const auto takes = hn::Or(hn::Gt(value, best), hn::IsNaN(value));
  best = hn::IfThenElse(takes, value, best);
  which = hn::IfThenElse(hn::RebindMask(whole, takes), hn::Set(whole, place), which);
}

/// ReLU, and what it cuts off named so.
template <class D, class V = hn::Vec<D>, class I = hn::Vec<hn::RebindToSigned<D>>>
HWY_INLINE void cut(D d, V& best, I& which) {
  const hn::RebindToSigned<D> whole;
  const auto cuts = hn::Le(best, hn::Zero(d));
  best = hn::IfThenElse(cuts, hn::Zero(d), best);
  which = hn::IfThenElse(hn::RebindMask(whole, cuts), hn::Set(whole, cut_off), which);
}

/// Adds the cells of one heatmap row, times a row of the kernel, to one or two rows of the strip.
template <bool upper, bool lower>
HWY_INLINE void add_cells(const Packed& packed, const Workspace& work, std::size_t row, std::size_t dy, float* strip,
                          std::size_t columns) {
  const Eight d;
  for (std::size_t v = 0; v < vectors_of_first; ++v) {
    const float* weight = packed.first.data() + v * eight_lanes;
    hn::Vec<Eight> of_upper[kernel], of_lower[kernel];
    for (std::size_t dx = 0; dx < kernel; ++dx) {
      if (upper) of_upper[dx] = hn::Load(d, weight + (dy * kernel + dx) * lanes_of_first);
      if (lower) of_lower[dx] = hn::Load(d, weight + ((dy - 1) * kernel + dx) * lanes_of_first);
    }
    for (std::size_t i = work.row_begin[row]; i < work.row_begin[row + 1]; ++i) {
      const auto value = hn::Set(d, work.cell_value[i]);
      float* at = strip + (work.cell_x[i] + margin) * lanes_of_first + v * eight_lanes;
      for (std::size_t dx = 0; dx < kernel; ++dx) {
        float* place = at - dx * lanes_of_first;
        if (upper) hn::Store(hn::MulAdd(value, of_upper[dx], hn::Load(d, place)), d, place);
        float* below = place + columns * lanes_of_first;
        if (lower) hn::Store(hn::MulAdd(value, of_lower[dx], hn::Load(d, below)), d, below);
      }
    }
  }
}

void first_forward(const LeNetLayers& layers, const Packed& packed, Kept& kept, Workspace& work) {
  const Eight d;
  const hn::RebindToSigned<Eight> whole;
  const hn::Rebind<std::uint8_t, Eight> bytes;
  const std::size_t columns = strip_columns(layers);
  const auto pooled_width = static_cast<std::size_t>(layers.first_pooled.width);
  float* strip = work.strip.data();
  for (std::size_t y = 0; y < static_cast<std::size_t>(layers.first_pooled.height); ++y) {
    for (std::size_t i = 0; i < 2 * columns; ++i) {
      for (std::size_t v = 0; v < lanes_of_first; v += eight_lanes)
        hn::Store(hn::Load(d, packed.first_bias.data() + v), d, strip + i * lanes_of_first + v);
    }
    add_cells<true, false>(packed, work, 2 * y, 0, strip, columns);
    for (std::size_t dy = 1; dy < kernel; ++dy) add_cells<true, true>(packed, work, 2 * y + dy, dy, strip, columns);
    add_cells<false, true>(packed, work, 2 * y + kernel, kernel, strip, columns);
    for (std::size_t x = 0; x < pooled_width; ++x) {
      const float* above = strip + (2 * x + margin) * lanes_of_first;
      const float* below = above + columns * lanes_of_first;
      const std::size_t out = (y * pooled_width + x) * first_channels;  // what is too much is written over by the next
      for (std::size_t v = 0; v < lanes_of_first; v += eight_lanes) {
        auto best = hn::Load(d, above + v);
        auto which = hn::Zero(whole);
        take_larger(d, best, which, hn::Load(d, above + lanes_of_first + v), 1);
        take_larger(d, best, which, hn::Load(d, below + v), 2);
        take_larger(d, best, which, hn::Load(d, below + lanes_of_first + v), 3);
        cut(d, best, which);
        hn::StoreU(best, d, kept.pooled.data() + out + v);
        hn::StoreU(hn::DemoteTo(bytes, which), bytes, kept.first_largest.data() + out + v);
      }
    }
  }
}

/// The second layer's answer on some of its tiles.
/// @param in     of each tile, where its field begins in the first layer's answer
/// @param value, which  16 for each tile
template <std::size_t count>
HWY_INLINE void convolve_tiles(const Packed& packed, const std::array<const float*, count>& in, std::size_t stride, float* value,
                               std::uint8_t* which) {
  const Sixteen d;
  const hn::RebindToSigned<Sixteen> whole;
  const hn::Rebind<std::uint8_t, Sixteen> bytes;
  constexpr std::size_t vectors = sixteen_lanes == 16 ? 1 : 2;  // at once
  for (std::size_t first = 0; first < second_channels; first += vectors * sixteen_lanes) {
    hn::Vec<Sixteen> sum[count][4][vectors];
    for (std::size_t t = 0; t < count; ++t) {
      for (std::size_t place = 0; place < 4; ++place) {
        for (std::size_t v = 0; v < vectors; ++v)
          sum[t][place][v] = hn::Load(d, packed.second_bias.data() + first + v * sixteen_lanes);
      }
    }
    for (std::size_t dy = 0; dy < kernel; ++dy) {
      const float* weight = packed.second.data() + dy * row_of_second * second_channels + first;
      const std::size_t row = dy * stride;
      for (std::size_t k = 0; k < row_of_second; ++k) {
        hn::Vec<Sixteen> w[vectors];
        for (std::size_t v = 0; v < vectors; ++v) w[v] = hn::Load(d, weight + k * second_channels + v * sixteen_lanes);
        for (std::size_t t = 0; t < count; ++t) {
          const float* x = in[t] + row + k;
          for (std::size_t place = 0; place < 4; ++place) {
            const auto value_here = hn::Set(d, x[place / 2 * stride + place % 2 * first_channels]);
            for (std::size_t v = 0; v < vectors; ++v) sum[t][place][v] = hn::MulAdd(value_here, w[v], sum[t][place][v]);
          }
        }
      }
    }
    for (std::size_t t = 0; t < count; ++t) {
      for (std::size_t v = 0; v < vectors; ++v) {
        auto best = sum[t][0][v];
        auto largest = hn::Zero(whole);
        for (std::size_t place = 1; place < 4; ++place) take_larger(d, best, largest, sum[t][place][v], static_cast<int>(place));
        cut(d, best, largest);
        const std::size_t out = t * second_channels + first + v * sixteen_lanes;
        hn::StoreU(best, d, value + out);
        hn::StoreU(hn::DemoteTo(bytes, largest), bytes, which + out);
      }
    }
  }
}

/// Which tiles of the second layer see a cell that is not 0, in their field of 16 x 16; the others get the empty answer.
void find_tiles(const LeNetLayers& layers, const Packed& packed, const std::uint8_t* heatmap, float* flat, Kept& kept,
                Workspace& work) {
  constexpr std::size_t field = 16, step = 4;
  const auto width = static_cast<std::size_t>(layers.input.width);
  const auto tiles_x = static_cast<std::size_t>(layers.second_pooled.width);
  const auto tiles_y = static_cast<std::size_t>(layers.second_pooled.height), tiles = tiles_x * tiles_y;
  work.tiles.clear();
  std::uint8_t* lit = work.lit.data();
  for (std::size_t y = 0; y < tiles_y; ++y) {
    std::copy_n(heatmap + y * step * width, width, lit);
    for (std::size_t row = 1; row < field; ++row) {
      const std::uint8_t* cells = heatmap + (y * step + row) * width;
      for (std::size_t x = 0; x < width; ++x) lit[x] = static_cast<std::uint8_t>(lit[x] | cells[x]);
    }
    for (std::size_t x = 0; x < tiles_x; ++x) {
      const std::size_t tile = y * tiles_x + x;
      std::uint64_t halves[2];
      std::memcpy(halves, lit + x * step, field);
      if ((halves[0] | halves[1]) != 0) {
        work.tiles.push_back(static_cast<std::uint32_t>(tile));
        continue;
      }
      for (std::size_t c = 0; c < second_channels; ++c) flat[c * tiles + tile] = packed.empty_answer[c];
      std::copy_n(packed.empty_largest.data(), second_channels, kept.second_largest.data() + tile * second_channels);
    }
  }
}

void second_forward(const LeNetLayers& layers, const Packed& packed, float* flat, Kept& kept, const Workspace& work) {
  constexpr std::size_t at_once = sixteen_lanes == 16 ? 3 : 1;  // as many as the processor has registers for
  const auto tiles_x = static_cast<std::size_t>(layers.second_pooled.width);
  const std::size_t tiles = tiles_x * static_cast<std::size_t>(layers.second_pooled.height);
  const std::size_t stride = static_cast<std::size_t>(layers.first_pooled.width) * first_channels;
  alignas(cache_line) float value[at_once * second_channels];
  std::uint8_t which[at_once * second_channels];
  const auto field_of = [&](std::size_t tile) {
    return kept.pooled.data() + tile / tiles_x * 2 * stride + tile % tiles_x * 2 * first_channels;
  };
  const auto put = [&](std::size_t i, std::size_t tile) {
    for (std::size_t c = 0; c < second_channels; ++c) flat[c * tiles + tile] = value[i * second_channels + c];
    std::copy_n(which + i * second_channels, second_channels, kept.second_largest.data() + tile * second_channels);
  };
  std::size_t i = 0;
  for (; i + at_once <= work.tiles.size(); i += at_once) {
    std::array<const float*, at_once> in;
    for (std::size_t t = 0; t < at_once; ++t) in[t] = field_of(work.tiles[i + t]);
    convolve_tiles<at_once>(packed, in, stride, value, which);
    for (std::size_t t = 0; t < at_once; ++t) put(t, work.tiles[i + t]);
  }
  for (; i < work.tiles.size(); ++i) {
    convolve_tiles<1>(packed, {field_of(work.tiles[i])}, stride, value, which);
    put(0, work.tiles[i]);
  }
}

void forward(const LeNetLayers& layers, const Packed& packed, const std::uint8_t* heatmap, float* flat, Kept& kept,
             Workspace& work) {
  find_cells(layers, heatmap, work);
  first_forward(layers, packed, kept, work);
  find_tiles(layers, packed, heatmap, flat, kept, work);
  second_forward(layers, packed, flat, kept, work);
}

/// The second layer's answer where the first layer's is that to an empty heatmap.
void answer_empty(Packed& packed) {
  constexpr std::size_t values = 36 * first_channels;  // 6 x 6 places
  alignas(cache_line) std::array<float, values + padded_row> field{};
  for (std::size_t i = 0; i < values; ++i) {
    const float bias = packed.first_bias[i % first_channels];
    field[i] = bias <= 0 ? 0.0F : bias;
  }
  convolve_tiles<1>(packed, {field.data()}, 6 * first_channels, packed.empty_answer.data(), packed.empty_largest.data());
}

}  // namespace
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
