// The backward pass of FusedConvolutions, after fused_forward-inl.hpp. No #pragma once: fused_convolutions.cpp reads this file
// for each set of vector instructions.
#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

#include "tactile/model/training/fused_convolutions.hpp"

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

constexpr std::size_t vectors_a_row = padded_row / sixteen_lanes;
constexpr std::size_t rows_at_once = sixteen_lanes == 16 ? 5 : sixteen_lanes == 8 ? 3 : 1;  // that registers hold

/// Adds to the first layer's gradient what channels of one tile, all largest at the same place, give it.
template <std::size_t rows>
HWY_INLINE void add_to_pooled(const Packed& packed, unsigned channels, const float* gradients, std::size_t first_row, float* out,
                              std::size_t stride) {
  const Sixteen d;
  hn::Vec<Sixteen> sum[rows][vectors_a_row];
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) sum[r][v] = hn::Zero(d);
  }
  for (unsigned left = channels; left != 0; left &= left - 1) {
    const auto c = static_cast<std::size_t>(__builtin_ctz(left));
    const auto gradient = hn::Set(d, gradients[c]);
    const float* weight = packed.second_back.data() + (c * kernel + first_row) * padded_row;
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t v = 0; v < vectors_a_row; ++v)
        sum[r][v] = hn::MulAdd(gradient, hn::Load(d, weight + r * padded_row + v * sixteen_lanes), sum[r][v]);
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
HWY_INLINE void add_to_weights(const std::uint32_t* places, const float* gradients, std::size_t count, const float* pooled,
                               std::size_t first_row, float* out, std::size_t stride) {
  const Sixteen d;
  hn::Vec<Sixteen> sum[rows][vectors_a_row];
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t v = 0; v < vectors_a_row; ++v) sum[r][v] = hn::Zero(d);
  }
  const float* from = pooled + first_row * stride;
  for (std::size_t i = 0; i < count; ++i) {
    const auto gradient = hn::Set(d, gradients[i]);
    const float* at = from + places[i];
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t v = 0; v < vectors_a_row; ++v)
        sum[r][v] = hn::MulAdd(gradient, hn::LoadU(d, at + r * stride + v * sixteen_lanes), sum[r][v]);
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
    float gradients[second_channels];
    for (std::size_t c = 0; c < second_channels; ++c) gradients[c] = gradient[c * tiles + tile];
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
        work.gradients[c][counts[c]] = gradients[c];
        ++counts[c];
        bias[c] += gradients[c];
      }
      for_rows([&](auto rows, std::size_t row)
                   HWY_ATTR { add_to_pooled<rows>(packed, channels, gradients, row, work.pooled_gradient.data() + at, stride); });
    }
  }
  for (std::size_t c = 0; c < second_channels; ++c) {
    sums.second_bias[c] += bias[c];
    for_rows([&](auto rows, std::size_t row) HWY_ATTR {
      add_to_weights<rows>(work.places[c].data(), work.gradients[c].data(), counts[c], kept.pooled.data(), row,
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
  alignas(cache_line) float weights[25 * lanes_of_first] = {};
  alignas(cache_line) float bias[lanes_of_first] = {};
  for (std::size_t y = 0; y < static_cast<std::size_t>(layers.first_pooled.height); ++y) {
    for (std::size_t v = 0; v < lanes_of_first; v += eight_lanes) {
      auto bias_here = hn::Zero(d);
      for (std::size_t x = 0; x < pooled_width; ++x) {
        const std::size_t in = (y * pooled_width + x) * first_channels + v;
        const auto gradient_here = hn::LoadU(d, work.pooled_gradient.data() + in);
        const auto which = hn::PromoteTo(whole, hn::LoadU(bytes, kept.first_largest.data() + in));
        bias_here =
            hn::Add(bias_here, hn::IfThenZeroElse(hn::RebindMask(d, hn::Eq(which, hn::Set(whole, cut_off))), gradient_here));
        float* above = strip + (2 * x + margin) * lanes_of_first + v;
        float* below = above + columns * lanes_of_first;
        const auto put = [&](int place, float* at) HWY_ATTR {
          hn::Store(hn::IfThenElseZero(hn::RebindMask(d, hn::Eq(which, hn::Set(whole, place))), gradient_here), d, at);
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
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
