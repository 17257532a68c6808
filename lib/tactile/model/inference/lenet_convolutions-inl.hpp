// The convolutions of lenet_kernel.cpp. No #pragma once: that file reads this one for each set of vector instructions.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "tactile/model/inference/lenet_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Sizes = LeNetSizes;
constexpr hn::CappedTag<float, Sizes::lanes> floats;
using Floats = decltype(floats);
using Vector = hn::Vec<Floats>;
constexpr std::size_t lanes = HWY_LANES(float) < Sizes::lanes ? HWY_LANES(float) : Sizes::lanes;
constexpr std::size_t parts = Sizes::second_channels / lanes;  ///< vectors that the second convolution's channels are
constexpr std::size_t taps = Sizes::taps, first_channels = Sizes::first_channels, hidden_row = Sizes::hidden_row;
constexpr std::size_t points = Sizes::points, block = Sizes::block;
/// Pooled outputs of the second convolution that are worked out together: enough sums to keep the multipliers busy, few enough
/// for the registers.
constexpr std::size_t together = std::max(std::size_t{1}, 6 / parts);

template <std::size_t... i, class Body>
HWY_INLINE void each_of(std::index_sequence<i...> /*numbers*/, const Body& body) {
  (body(std::integral_constant<std::size_t, i>{}), ...);
}

/// body(0), body(1), … with numbers that are known when compiling, so that arrays of vectors become registers.
template <std::size_t count, class Body>
HWY_INLINE void each(const Body& body) {
  each_of(std::make_index_sequence<count>{}, body);
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE bool any_lit(const std::uint8_t* cells) {
  return std::any_of(cells, cells + 2 * Sizes::lanes, [](std::uint8_t cell) { return cell != 0; });
}

HWY_INLINE void take_apart(const std::uint8_t* cells, float* even, float* odd, std::uint8_t* lit) {
  constexpr float scale = 1.0F / 255.0F;
  for (std::size_t k = 0; k < Sizes::lanes; ++k) {
    even[k] = static_cast<float>(cells[2 * k]) * scale;
    odd[k] = static_cast<float>(cells[2 * k + 1]) * scale;
    lit[k] = static_cast<std::uint8_t>(lit[k] | cells[2 * k] | cells[2 * k + 1]);
  }
}
#else
constexpr hn::Rebind<std::uint16_t, Floats> pairs_of_cells;
constexpr hn::Repartition<std::uint8_t, hn::Rebind<std::uint16_t, Floats> > single_cells;

HWY_INLINE bool any_lit(const std::uint8_t* cells) {
  auto seen = hn::Zero(pairs_of_cells);
  for (std::size_t k = 0; k < Sizes::lanes; k += lanes)
    seen = hn::Or(seen, hn::BitCast(pairs_of_cells, hn::LoadU(single_cells, cells + 2 * k)));
  return !hn::AllTrue(pairs_of_cells, hn::Eq(seen, hn::Zero(pairs_of_cells)));
}

/// 16 pairs of a row's cells as numbers in [0, 1]; `lit` becomes another than 0 where a cell of the pair is.
HWY_INLINE void take_apart(const std::uint8_t* cells, float* even, float* odd, std::uint8_t* lit) {
  const hn::Rebind<std::uint8_t, Floats> bytes;
  const hn::Rebind<std::int16_t, Floats> signed_pairs;
  const hn::Rebind<std::int32_t, Floats> whole;
  const auto low = hn::Set(pairs_of_cells, std::uint16_t{255});
  const auto scale = hn::Set(floats, 1.0F / 255.0F);
  for (std::size_t k = 0; k < Sizes::lanes; k += lanes) {
    const auto pairs = hn::BitCast(pairs_of_cells, hn::LoadU(single_cells, cells + 2 * k));
    const auto left = hn::And(pairs, low), right = hn::ShiftRight<8>(pairs);
    hn::Store(hn::Mul(hn::ConvertTo(floats, hn::PromoteTo(whole, left)), scale), floats, even + k);
    hn::Store(hn::Mul(hn::ConvertTo(floats, hn::PromoteTo(whole, right)), scale), floats, odd + k);
    const auto either = hn::DemoteTo(bytes, hn::BitCast(signed_pairs, hn::Or(left, right)));
    hn::StoreU(hn::Or(either, hn::LoadU(bytes, lit + k)), bytes, lit + k);
  }
}
#endif

/// Takes the heatmap's pairs of columns apart, and notes where a pair of rows is lit. Returns whether any cell is.
HWY_ATTR bool spread(const LeNetPlan& plan, LeNetMemory& memory, const std::uint8_t* heatmap, bool skip_empty) {
  const auto width = static_cast<std::size_t>(plan.layers.input.width), used = 2 * plan.input_pairs;
  bool any = false;
  for (std::size_t r = 0; r < plan.input_rows / 2; ++r) {
    for (std::size_t chunk = 0; chunk + 1 < plan.pair_chunks; ++chunk) {
      const std::size_t first_pair = chunk * Sizes::lanes;
      std::array<std::uint8_t, 4 * Sizes::lanes> ends;
      const std::uint8_t *upper = heatmap + 2 * r * width + 2 * first_pair, *lower = upper + width;
      if (const std::size_t there = used - 2 * first_pair; there < 2 * Sizes::lanes) {  // the row's last ones
        ends.fill(0);
        std::copy_n(upper, there, ends.data());
        std::copy_n(lower, there, ends.data() + 2 * Sizes::lanes);
        upper = ends.data(), lower = ends.data() + 2 * Sizes::lanes;
      }
      std::uint8_t& flag = memory.lit_chunk[r * plan.pair_chunks + chunk];
      const bool lit = any_lit(upper) || any_lit(lower);
      any |= lit;
      if (!lit && flag == 0 && skip_empty) continue;
      flag = lit ? 1 : 0;
      const std::size_t place = 2 * r * plan.pair_stride + first_pair;
      std::uint8_t* const lit_pairs = &memory.lit[r * plan.pair_stride + first_pair];
      std::fill_n(lit_pairs, Sizes::lanes, std::uint8_t{0});
      take_apart(upper, &memory.even[place], &memory.odd[place], lit_pairs);
      take_apart(lower, &memory.even[place + plan.pair_stride], &memory.odd[place + plan.pair_stride], lit_pairs);
    }
  }
  return any;
}

/// Three channels of the first convolution, pooled, at `lanes` columns of a row from pair `k` on.
template <std::size_t first_channel>
HWY_INLINE void first_channels_at(const LeNetPlan& plan, LeNetMemory& memory, std::size_t row, std::size_t k) {
  constexpr std::size_t channels = 3;
  Vector sums[channels * 4];  // [channel][row of the block][column of the block]
  each<channels>([&](auto c) HWY_ATTR {
    const Vector bias = hn::Set(floats, plan.first_bias[first_channel + c]);
    each<4>([&](auto i) HWY_ATTR { sums[c * 4 + i] = bias; });
  });
  const float* const weights = plan.first_weights.data() + first_channel;
  const auto add_row = [&](std::size_t y, auto lower) HWY_ATTR {
    const float* even = &memory.even[(2 * row + y) * plan.pair_stride + k];
    const float* odd = &memory.odd[(2 * row + y) * plan.pair_stride + k];
    const Vector in[6] = {hn::LoadU(floats, even),    hn::LoadU(floats, odd),      hn::LoadU(floats, even + 1),
                          hn::LoadU(floats, odd + 1), hn::LoadU(floats, even + 2), hn::LoadU(floats, odd + 2)};
    const float* const of_row = weights + (y - lower) * taps * first_channels;
    each<taps>([&](auto x) HWY_ATTR {
      each<channels>([&](auto c) HWY_ATTR {
        const Vector weight = hn::Set(floats, of_row[x * first_channels + c]);
        sums[c * 4 + lower * 2] = hn::MulAdd(in[x], weight, sums[c * 4 + lower * 2]);
        sums[c * 4 + lower * 2 + 1] = hn::MulAdd(in[x + 1], weight, sums[c * 4 + lower * 2 + 1]);
      });
    });
  };
  constexpr std::integral_constant<std::size_t, 0> above;
  constexpr std::integral_constant<std::size_t, 1> below;
  for (std::size_t y = 0; y < taps; ++y) {
    add_row(y, above);
    add_row(y + 1, below);
  }
  each<channels>([&](auto c) HWY_ATTR {
    const Vector* of = sums + c * 4;
    const Vector largest = hn::Max(hn::Max(of[0], of[1]), hn::Max(of[2], of[3]));
    hn::StoreU(hn::Max(largest, hn::Zero(floats)), floats,
               &memory.pooled[(row * first_channels + first_channel + c) * plan.pooled_stride + k]);
  });
}

/// Six values of a row, `values[2k]` to `values[2k + 5]`, become those of a polynomial at 0, 1, -1, 2, -2 and infinity, by which
/// two outputs of a convolution of five take six multiplications in the place of ten (Winograd's F(2, 5)), for `lanes` columns.
HWY_INLINE void take_at_points(const float* values, Vector* out) {
  const auto pair = [&](std::size_t offset, Vector& even, Vector& odd) HWY_ATTR {
#if HWY_TARGET == HWY_SCALAR
    even = hn::LoadU(floats, values + offset), odd = hn::LoadU(floats, values + offset + 1);
#else
    const Vector low = hn::LoadU(floats, values + offset), high = hn::LoadU(floats, values + offset + lanes);
    even = hn::ConcatEven(floats, high, low), odd = hn::ConcatOdd(floats, high, low);
#endif
  };
  Vector v[points];
  pair(0, v[0], v[1]);
  pair(2, v[2], v[3]);
  pair(4, v[4], v[5]);
  const Vector four = hn::Set(floats, 4.0F), five = hn::Set(floats, 5.0F), two = hn::Set(floats, 2.0F);
  const Vector a = hn::NegMulAdd(four, v[2], v[4]), b = hn::NegMulAdd(four, v[1], v[3]);
  const Vector c = hn::Sub(v[4], v[2]), d = hn::Mul(two, hn::Sub(v[3], v[1]));
  out[0] = hn::MulAdd(four, v[0], hn::NegMulAdd(five, v[2], v[4]));
  out[1] = hn::Add(a, b);
  out[2] = hn::Sub(a, b);
  out[3] = hn::Add(c, d);
  out[4] = hn::Sub(c, d);
  out[5] = hn::MulAdd(four, v[1], hn::NegMulAdd(five, v[3], v[5]));
}

/// A row of the first pooled layer as the second convolution takes it.
HWY_ATTR void take_row_at_points(const LeNetPlan& plan, LeNetMemory& memory, std::size_t row) {
  float* const place = &memory.at_points[row * plan.blocks * points * first_channels * block];
  for (std::size_t c = 0; c < first_channels; ++c) {
    const float* const values = &memory.pooled[(row * first_channels + c) * plan.pooled_stride];
    for (std::size_t k = 0; k < plan.blocks * block; k += lanes) {
      Vector at[points];
      take_at_points(values + 2 * k, at);
      each<points>([&](auto p) HWY_ATTR {
        float* const to = place + k / block * points * first_channels * block + (p * first_channels + c) * block + k % block;
        if constexpr (lanes > block) {
          alignas(cache_line) float both[lanes];
          hn::Store(at[p], floats, both);
          std::memcpy(to, both, block * sizeof(float));
          if (k + block < plan.blocks * block)
            std::memcpy(to + points * first_channels * block, both + lanes / 2, block * sizeof(float));
        } else {
          hn::StoreU(at[p], floats, to);
        }
      });
    }
  }
}

/// The first pooled layer; where no cell of a chunk's receptive field is lit it stays as an empty heatmap has it.
HWY_ATTR void first_layer(const LeNetPlan& plan, LeNetMemory& memory, bool skip_empty) {
  const auto rows = static_cast<std::size_t>(plan.layers.first_pooled.height);
  const auto columns = static_cast<std::size_t>(plan.layers.first_pooled.width);
  for (std::size_t row = 0; row < rows; ++row) {
    bool changed = false;
    for (std::size_t chunk = 0; chunk * Sizes::lanes < columns; ++chunk) {
      const std::uint8_t* flags = &memory.lit_chunk[row * plan.pair_chunks + chunk];
      std::uint8_t lit = 0;
      for (std::size_t y = 0; y < 3; ++y) lit |= flags[y * plan.pair_chunks] | flags[y * plan.pair_chunks + 1];
      std::uint8_t& computed = memory.computed[row * plan.pair_chunks + chunk];
      if (lit == 0 && skip_empty) {
        if (computed == 0) continue;
        changed = true;
        for (std::size_t c = 0; c < first_channels; ++c) {
          std::fill_n(&memory.pooled[(row * first_channels + c) * plan.pooled_stride + chunk * Sizes::lanes], Sizes::lanes,
                      plan.first_empty[c]);
        }
        computed = 0;
        continue;
      }
      computed = 1;
      changed = true;
      for (std::size_t k = chunk * Sizes::lanes; k < (chunk + 1) * Sizes::lanes; k += lanes) {
        first_channels_at<0>(plan, memory, row, k);
        first_channels_at<3>(plan, memory, row, k);
      }
    }
    if (changed) take_row_at_points(plan, memory, row);
  }
}

/// The columns of the second pooled layer's row that depend on a lit cell, ascending; how many.
HWY_ATTR std::size_t columns_of(const LeNetPlan& plan, LeNetMemory& memory, std::size_t row, bool skip_empty) {
  const auto columns = static_cast<std::size_t>(plan.layers.second_pooled.width);
  std::size_t count = 0;
  if (!skip_empty) {
    for (; count < columns; ++count) memory.columns[count] = static_cast<std::uint32_t>(count);
    return count;
  }
  constexpr std::size_t field = 8;  // pairs each way that an output depends on
  const hn::CappedTag<std::uint8_t, 16> bytes;
  const std::size_t step = hn::Lanes(bytes);
  const std::uint8_t* lit = &memory.lit[2 * row * plan.pair_stride];
  for (std::size_t k = 0; k < plan.input_pairs; k += step) {
    auto any = hn::LoadU(bytes, lit + k);
    for (std::size_t y = 1; y < field; ++y) any = hn::Or(any, hn::LoadU(bytes, lit + y * plan.pair_stride + k));
    hn::StoreU(any, bytes, &memory.lit_row[k]);
  }
  for (std::size_t column = 0; column < columns; ++column) {
    std::uint64_t of_column = 0;
    std::memcpy(&of_column, &memory.lit_row[2 * column], field);
    memory.columns[count] = static_cast<std::uint32_t>(column);
    count += of_column != 0 ? 1 : 0;
  }
  return count;
}

/// What is read into the cache meanwhile.
struct Ahead {
  const char* weights = nullptr;
  std::size_t row_bytes = 0;
  const std::uint32_t* rows = nullptr;
  std::size_t count = 0;
};

constexpr int to_second_level = 2;

HWY_INLINE void fetch_row(const Ahead& ahead, std::size_t i) {
  if (i >= ahead.count) return;
  const char* row = ahead.weights + ahead.rows[i] * ahead.row_bytes;
  const auto fetch = [row](auto weight_bytes) HWY_ATTR {
    each<hidden_row * weight_bytes / cache_line>(
        [&](auto line) HWY_ATTR { __builtin_prefetch(row + line * cache_line, 0, to_second_level); });
  };
  if (ahead.row_bytes == hidden_row) {
    fetch(std::integral_constant<std::size_t, 1>{});
  } else if (ahead.row_bytes == 2 * hidden_row) {
    fetch(std::integral_constant<std::size_t, 2>{});
  } else {
    fetch(std::integral_constant<std::size_t, 4>{});
  }
}

/// `together` outputs of the second convolution, pooled and activated: their products at each point, then from these the outputs.
HWY_INLINE void second_at(const LeNetPlan& plan, const float* const* in, const Ahead& ahead, Vector* out) {
  constexpr std::size_t sums = together * 2 * parts;  // [output][row of the block][part]
  alignas(cache_line) float products[points][sums * lanes];
  const std::size_t row = plan.blocks * points * first_channels * block;
  const float* weights = plan.second_weights.data();
  for (std::size_t point = 0; point < points; ++point) {
    Vector sum[sums];
    each<sums>([&](auto i) HWY_ATTR { sum[i] = hn::Zero(floats); });
    for (std::size_t c = 0; c < first_channels; ++c, weights += taps * Sizes::second_channels) {
      fetch_row(ahead, (point * first_channels + c) * 3);
      fetch_row(ahead, (point * first_channels + c) * 3 + 1);
      fetch_row(ahead, (point * first_channels + c) * 3 + 2);
      const std::size_t offset = (point * first_channels + c) * block;
      each<taps + 1>([&](auto y) HWY_ATTR {  // a row of values is above for one of the block's rows, below for the other
        each<together>([&](auto k) HWY_ATTR {
          const Vector value = hn::Set(floats, in[k][offset + y * row]);
          each<parts>([&](auto part) HWY_ATTR {
            if constexpr (y < taps) {
              const Vector weight = hn::Load(floats, weights + y * Sizes::second_channels + part * lanes);
              sum[k * 2 * parts + part] = hn::MulAdd(value, weight, sum[k * 2 * parts + part]);
            }
            if constexpr (y > 0) {
              const Vector weight = hn::Load(floats, weights + (y - 1) * Sizes::second_channels + part * lanes);
              sum[(k * 2 + 1) * parts + part] = hn::MulAdd(value, weight, sum[(k * 2 + 1) * parts + part]);
            }
          });
        });
      });
    }
    each<sums>([&](auto i) HWY_ATTR { hn::Store(sum[i], floats, products[point] + i * lanes); });
  }
  const Vector two = hn::Set(floats, 2.0F), zero = hn::Zero(floats);
  for (std::size_t k = 0; k < together; ++k) {
    for (std::size_t part = 0; part < parts; ++part) {
      Vector largest = zero;
      each<2>([&](auto y) HWY_ATTR {
        Vector m[points];
        each<points>([&](auto p) HWY_ATTR { m[p] = hn::Load(floats, products[p] + ((k * 2 + y) * parts + part) * lanes); });
        const Vector left = hn::Add(m[0], hn::Add(hn::Add(m[1], m[2]), hn::Add(m[3], m[4])));
        const Vector right = hn::Add(m[5], hn::MulAdd(two, hn::Sub(m[3], m[4]), hn::Sub(m[1], m[2])));
        const Vector larger = hn::Max(left, right);
        if constexpr (y == 0) largest = larger;
        if constexpr (y == 1) largest = hn::Max(largest, larger);
      });
      out[k * parts + part] = hn::Max(hn::Add(largest, hn::Load(floats, &plan.second_bias[part * lanes])), zero);
    }
  }
}

}  // namespace
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
