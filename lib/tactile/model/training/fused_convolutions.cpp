#include "tactile/model/training/fused_convolutions.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

// Highway compiles what follows once for each kind of processor and takes the best of them at run time. Vectors without a fixed
// size, of which no arrays can be made, are left out.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/training/fused_convolutions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tactile::HWY_NAMESPACE {
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
  alignas(64) float value[at_once * second_channels];
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
  alignas(64) std::array<float, 6 * 6 * first_channels + padded_row> field{};
  for (std::size_t i = 0; i < 6 * 6 * first_channels; ++i) {
    const float bias = packed.first_bias[i % first_channels];
    field[i] = bias <= 0 ? 0.0F : bias;
  }
  convolve_tiles<1>(packed, {field.data()}, 6 * first_channels, packed.empty_answer.data(), packed.empty_largest.data());
}

constexpr std::size_t vectors_a_row = padded_row / sixteen_lanes;
constexpr std::size_t rows_at_once = sixteen_lanes == 16 ? 5 : sixteen_lanes == 8 ? 3 : 1;  // that registers hold

/// Adds to the first layer's gradient what channels of one tile, all largest at the same place, give it.
template <std::size_t rows>
HWY_INLINE void add_to_pooled(const Packed& packed, unsigned channels, const float* slopes, std::size_t first_row, float* out,
                              std::size_t stride) {
  const Sixteen d;
  hn::Vec<Sixteen> sum[rows][vectors_a_row];
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) sum[r][v] = hn::Zero(d);
  }
  for (unsigned left = channels; left != 0; left &= left - 1) {
    const auto c = static_cast<std::size_t>(__builtin_ctz(left));
    const auto slope = hn::Set(d, slopes[c]);
    const float* weight = packed.second_back.data() + (c * kernel + first_row) * padded_row;
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t v = 0; v < vectors_a_row; ++v)
        sum[r][v] = hn::MulAdd(slope, hn::Load(d, weight + r * padded_row + v * sixteen_lanes), sum[r][v]);
    }
  }
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) {
      float* at = out + (first_row + r) * stride + v * sixteen_lanes;
      hn::StoreU(hn::Add(hn::LoadU(d, at), sum[r][v]), d, at);
    }
  }
}

/// Adds one channel's gradient of the weights.
template <std::size_t rows>
HWY_INLINE void add_to_weights(const std::uint32_t* places, const float* slopes, std::size_t count, const float* pooled,
                               std::size_t first_row, float* out, std::size_t stride) {
  const Sixteen d;
  hn::Vec<Sixteen> sum[rows][vectors_a_row];
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) sum[r][v] = hn::Zero(d);
  }
  const float* from = pooled + first_row * stride;
  for (std::size_t i = 0; i < count; ++i) {
    const auto slope = hn::Set(d, slopes[i]);
    const float* at = from + places[i];
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t v = 0; v < vectors_a_row; ++v)
        sum[r][v] = hn::MulAdd(slope, hn::LoadU(d, at + r * stride + v * sixteen_lanes), sum[r][v]);
    }
  }
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) {
      float* at = out + (first_row + r) * padded_row + v * sixteen_lanes;
      hn::Store(hn::Add(hn::Load(d, at), sum[r][v]), d, at);
    }
  }
}

/// Calls `work(rows, first_row)` for the kernel's rows, `rows` being a constant.
template <class Work>
HWY_INLINE void for_rows(const Work& work) {
  std::size_t row = 0;
  for (; row + rows_at_once <= kernel; row += rows_at_once) work(std::integral_constant<std::size_t, rows_at_once>(), row);
  constexpr std::size_t rest = kernel % rows_at_once;
  if constexpr (rest > 0) work(std::integral_constant<std::size_t, rest>(), row);
}

void second_backward(const LeNetLayers& layers, const Packed& packed, const Kept& kept, const float* gradient, Gradients& sums,
                     Workspace& work) {
  const hn::CappedTag<std::uint8_t, 16> bytes;
  constexpr std::size_t byte_lanes = hn::MaxLanes(bytes);
  const auto tiles_x = static_cast<std::size_t>(layers.second_pooled.width);
  const auto tiles_y = static_cast<std::size_t>(layers.second_pooled.height), tiles = tiles_x * tiles_y;
  const std::size_t stride = static_cast<std::size_t>(layers.first_pooled.width) * first_channels;
  std::fill(work.pooled_gradient.begin(), work.pooled_gradient.end(), 0.0F);
  std::array<std::size_t, second_channels> counts{};
  std::array<float, second_channels> bias{};
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    float slopes[second_channels];
    for (std::size_t c = 0; c < second_channels; ++c) slopes[c] = gradient[c * tiles + tile];
    const std::size_t corner = tile / tiles_x * 2 * stride + tile % tiles_x * 2 * first_channels;
    const std::uint8_t* largest = kept.second_largest.data() + tile * second_channels;
    for (std::size_t place = 0; place < 4; ++place) {
      unsigned channels = 0;
      for (std::size_t c = 0; c < second_channels; c += byte_lanes) {
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(bytes, hn::Eq(hn::LoadU(bytes, largest + c), hn::Set(bytes, static_cast<std::uint8_t>(place))), bits);
        channels |= (bits[0] | static_cast<unsigned>(bits[1]) << 8U) << c;
      }
      if (channels == 0) continue;
      const std::size_t at = corner + place / 2 * stride + place % 2 * first_channels;
      for (unsigned left = channels; left != 0; left &= left - 1) {
        const auto c = static_cast<std::size_t>(__builtin_ctz(left));
        work.places[c][counts[c]] = static_cast<std::uint32_t>(at);
        work.slopes[c][counts[c]] = slopes[c];
        ++counts[c];
        bias[c] += slopes[c];
      }
      for_rows([&](auto rows, std::size_t row)
                   HWY_ATTR { add_to_pooled<rows>(packed, channels, slopes, row, work.pooled_gradient.data() + at, stride); });
    }
  }
  for (std::size_t c = 0; c < second_channels; ++c) {
    sums.second_bias[c] += bias[c];
    for_rows([&](auto rows, std::size_t row) HWY_ATTR {
      add_to_weights<rows>(work.places[c].data(), work.slopes[c].data(), counts[c], kept.pooled.data(), row,
                           sums.second.data() + c * kernel * padded_row, stride);
    });
  }
}

/// Adds what the cells of one heatmap row give to the gradients of one or two rows of the first kernel.
template <bool upper, bool lower>
HWY_INLINE void add_cell_gradients(const Workspace& work, std::size_t row, std::size_t dy, const float* strip,
                                   std::size_t columns, float* out) {
  const Eight d;
  for (std::size_t v = 0; v < vectors_of_first; ++v) {
    hn::Vec<Eight> of_upper[kernel], of_lower[kernel];
    for (std::size_t dx = 0; dx < kernel; ++dx) of_upper[dx] = of_lower[dx] = hn::Zero(d);
    for (std::size_t i = work.row_begin[row]; i < work.row_begin[row + 1]; ++i) {
      const auto value = hn::Set(d, work.cell_value[i]);
      const float* at = strip + (work.cell_x[i] + margin) * lanes_of_first + v * eight_lanes;
      for (std::size_t dx = 0; dx < kernel; ++dx) {
        const float* place = at - dx * lanes_of_first;
        if (upper) of_upper[dx] = hn::MulAdd(value, hn::Load(d, place), of_upper[dx]);
        if (lower) of_lower[dx] = hn::MulAdd(value, hn::Load(d, place + columns * lanes_of_first), of_lower[dx]);
      }
    }
    for (std::size_t dx = 0; dx < kernel; ++dx) {
      float* of_dy = out + (dy * kernel + dx) * lanes_of_first + v * eight_lanes;
      if (upper) hn::Store(hn::Add(hn::Load(d, of_dy), of_upper[dx]), d, of_dy);
      float* above = of_dy - kernel * lanes_of_first;
      if (lower) hn::Store(hn::Add(hn::Load(d, above), of_lower[dx]), d, above);
    }
  }
}

void first_backward(const LeNetLayers& layers, const Kept& kept, Gradients& sums, Workspace& work) {
  const Eight d;
  const hn::RebindToSigned<Eight> whole;
  const hn::Rebind<std::uint8_t, Eight> bytes;
  const std::size_t columns = strip_columns(layers);
  const auto pooled_width = static_cast<std::size_t>(layers.first_pooled.width);
  float* strip = work.strip.data();
  std::fill(work.strip.begin(), work.strip.end(), 0.0F);
  alignas(64) float weights[25 * lanes_of_first] = {};
  alignas(64) float bias[lanes_of_first] = {};
  for (std::size_t y = 0; y < static_cast<std::size_t>(layers.first_pooled.height); ++y) {
    for (std::size_t v = 0; v < lanes_of_first; v += eight_lanes) {
      auto bias_here = hn::Zero(d);
      for (std::size_t x = 0; x < pooled_width; ++x) {
        const std::size_t in = (y * pooled_width + x) * first_channels + v;
        const auto slope = hn::LoadU(d, work.pooled_gradient.data() + in);
        const auto which = hn::PromoteTo(whole, hn::LoadU(bytes, kept.first_largest.data() + in));
        bias_here = hn::Add(bias_here, hn::IfThenZeroElse(hn::RebindMask(d, hn::Eq(which, hn::Set(whole, cut_off))), slope));
        float* above = strip + (2 * x + margin) * lanes_of_first + v;
        float* below = above + columns * lanes_of_first;
        const auto put = [&](int place, float* at) HWY_ATTR {
          hn::Store(hn::IfThenElseZero(hn::RebindMask(d, hn::Eq(which, hn::Set(whole, place))), slope), d, at);
        };
        put(0, above);
        put(1, above + lanes_of_first);
        put(2, below);
        put(3, below + lanes_of_first);
      }
      hn::Store(hn::Add(hn::Load(d, bias + v), bias_here), d, bias + v);
    }
    add_cell_gradients<true, false>(work, 2 * y, 0, strip, columns, weights);
    for (std::size_t dy = 1; dy < kernel; ++dy) add_cell_gradients<true, true>(work, 2 * y + dy, dy, strip, columns, weights);
    add_cell_gradients<false, true>(work, 2 * y + kernel, kernel, strip, columns, weights);
  }
  for (std::size_t i = 0; i < 25 * lanes_of_first; ++i) sums.first[i] += weights[i];
  for (std::size_t i = 0; i < lanes_of_first; ++i) sums.first_bias[i] += bias[i];
}

void backward(const LeNetLayers& layers, const Packed& packed, const std::uint8_t* heatmap, const Kept& kept,
              const float* gradient, Gradients& sums, Workspace& work) {
  second_backward(layers, packed, kept, gradient, sums, work);
  find_cells(layers, heatmap, work);
  first_backward(layers, kept, sums, work);
}

}  // namespace
}  // namespace tactile::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile {
namespace {

HWY_EXPORT(forward);
HWY_EXPORT(backward);
HWY_EXPORT(answer_empty);

constexpr std::size_t channels_1 = 6, channels_2 = 16, side = 5, beyond = 64;  // floats that a vector may read or write too many

std::size_t cells_of(SensorSize size) { return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height); }

/// Calls `pair(ours, theirs)` for each weight of the first and of the second layer: its place in the passes' layout and
/// libtorch's.
template <class First, class Second>
void for_weights(const First& first, const Second& second) {
  for (std::size_t c = 0; c < channels_1; ++c) {
    for (std::size_t tap = 0; tap < side * side; ++tap) first(tap, c);
  }
  for (std::size_t c = 0; c < channels_2; ++c) {
    for (std::size_t in = 0; in < channels_1; ++in) {
      for (std::size_t dy = 0; dy < side; ++dy) {
        for (std::size_t dx = 0; dx < side; ++dx)
          second(c, dy, dx * channels_1 + in, ((c * channels_1 + in) * side + dy) * side + dx);
      }
    }
  }
}

}  // namespace

FusedConvolutions::FusedConvolutions(const LeNetLayers& layers) : layers_(layers) {}

void FusedConvolutions::set(const ConvolutionValues<const float>& values) {
  for_weights([&](std::size_t tap, std::size_t c) { packed_.first[tap * 8 + c] = values.first_weight[c * side * side + tap]; },
              [&](std::size_t c, std::size_t dy, std::size_t k, std::size_t theirs) {
                packed_.second[(dy * 30 + k) * channels_2 + c] = values.second_weight[theirs];
                packed_.second_back[(c * side + dy) * 32 + k] = values.second_weight[theirs];
              });
  std::copy_n(values.first_bias, channels_1, packed_.first_bias.begin());
  std::copy_n(values.second_bias, channels_2, packed_.second_bias.begin());
  HWY_DYNAMIC_DISPATCH(answer_empty)(packed_);
}

FusedConvolutions::Kept FusedConvolutions::make_kept() const {
  const std::size_t first = cells_of(layers_.first_pooled) * channels_1 + beyond;
  return {LineVector(first), std::vector<std::uint8_t>(first), std::vector<std::uint8_t>(layers_.flat)};
}

FusedConvolutions::Workspace FusedConvolutions::make_workspace() const {
  const std::size_t cells = cells_of(layers_.input), tiles = cells_of(layers_.second_pooled);
  Workspace work;
  work.row_begin.resize(static_cast<std::size_t>(layers_.input.height) + 1);
  work.cell_x.resize(cells + 1);  // one is written on trial
  work.cell_value.resize(cells + 1);
  work.strip.resize(2 * (static_cast<std::size_t>(layers_.input.width) + 4) * 8);
  work.pooled_gradient.resize(cells_of(layers_.first_pooled) * channels_1 + beyond);
  work.tiles.reserve(tiles);
  work.lit.resize(static_cast<std::size_t>(layers_.input.width));
  for (std::size_t c = 0; c < channels_2; ++c) {
    work.places[c].resize(tiles);
    work.slopes[c].resize(tiles);
  }
  return work;
}

void FusedConvolutions::forward(std::span<const std::uint8_t> heatmap, std::span<float> flat, Kept& kept,
                                Workspace& workspace) const {
  HWY_DYNAMIC_DISPATCH(forward)(layers_, packed_, heatmap.data(), flat.data(), kept, workspace);
}

void FusedConvolutions::backward(std::span<const std::uint8_t> heatmap, const Kept& kept, std::span<const float> gradient,
                                 Gradients& sums, Workspace& workspace) const {
  HWY_DYNAMIC_DISPATCH(backward)(layers_, packed_, heatmap.data(), kept, gradient.data(), sums, workspace);
}

void FusedConvolutions::Gradients::clear() {
  for (LineVector* values : {&first, &first_bias, &second, &second_bias}) std::fill(values->begin(), values->end(), 0.0F);
}

void FusedConvolutions::Gradients::add(const Gradients& other) {
  const auto add_all = [](LineVector& to, const LineVector& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  };
  add_all(first, other.first);
  add_all(first_bias, other.first_bias);
  add_all(second, other.second);
  add_all(second_bias, other.second_bias);
}

void FusedConvolutions::Gradients::write(const ConvolutionValues<float>& values) const {
  for_weights([&](std::size_t tap, std::size_t c) { values.first_weight[c * side * side + tap] = first[tap * 8 + c]; },
              [&](std::size_t c, std::size_t dy, std::size_t k, std::size_t theirs) {
                values.second_weight[theirs] = second[(c * side + dy) * 32 + k];
              });
  std::copy_n(first_bias.begin(), channels_1, values.first_bias);
  std::copy_n(second_bias.begin(), channels_2, values.second_bias);
}

}  // namespace tactile
#endif
