// Compiled once for each set of vector instructions: foreach_target.h reads this file again for each.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/inference/lenet_kernel.cpp"
// Vectors of unknown length cannot be in arrays, as here.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include "tactile/model/inference/lenet_kernel.hpp"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "tactile/model/inference/lenet_convolutions-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

/// Appends the nonzero differences, or all.
template <class N>
HWY_INLINE std::size_t append(typename N::ChannelVector difference, std::size_t row, bool skip_empty, float* differences,
                              std::uint32_t* rows) {
  constexpr typename N::Channels channels;
  const hn::RebindToUnsigned<typename N::Channels> numbers;
  const auto own_rows = hn::Iota(numbers, static_cast<std::uint32_t>(row));
  if (!skip_empty) {
    hn::StoreU(difference, channels, differences);
    hn::StoreU(own_rows, numbers, rows);
    return N::channel_lanes;
  }
  const auto other = hn::Ne(difference, hn::Zero(channels));
  hn::StoreU(hn::Compress(difference, other), channels, differences);
  hn::StoreU(hn::Compress(own_rows, hn::RebindMask(numbers, other)), numbers, rows);
  return hn::CountTrue(channels, other);
}

HWY_INLINE Vector weights_at(const float* weights) { return hn::Load(floats, weights); }

HWY_INLINE Vector weights_at(const std::uint16_t* weights) {
  const hn::Rebind<std::uint16_t, Floats> upper_halves;
  const hn::Rebind<std::uint32_t, Floats> bits;
  return hn::BitCast(floats, hn::ShiftLeft<16>(hn::PromoteTo(bits, hn::Load(upper_halves, weights))));
}

HWY_INLINE Vector weights_at(const std::int8_t* weights) {
  const hn::Rebind<std::int8_t, Floats> bytes;
  const hn::Rebind<std::int32_t, Floats> whole;
  return hn::ConvertTo(floats, hn::PromoteTo(whole, hn::Load(bytes, weights)));
}

/// use(weights of the first fully connected layer), in the format that this network has them in
template <class Use>
HWY_INLINE void with_hidden(const LeNetPlan& plan, const Use& use) {
  if (!plan.hidden_bytes.empty()) return use(plan.hidden_bytes.data());
  if (!plan.hidden_bf16.empty()) return use(plan.hidden_bf16.data());
  use(plan.hidden_weights.data());
}

/// sums += value of each input times its row of weights, in their order.
template <std::size_t row_size, class Weight>
HWY_INLINE void add_rows(const Weight* weights, const float* values, const std::uint32_t* rows, std::size_t count, float* sums) {
  constexpr std::size_t wide = std::min(std::size_t{8}, row_size / lanes);
  for (std::size_t first = 0; first < row_size; first += wide * lanes) {
    Vector sum[wide];
    each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::Load(floats, sums + first + i * lanes); });
    for (std::size_t k = 0; k < count; ++k) {
      const Vector value = hn::Set(floats, values[k]);
      const Weight* of_row = weights + static_cast<std::size_t>(rows[k]) * row_size + first;
      each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::MulAdd(value, weights_at(of_row + i * lanes), sum[i]); });
    }
    each<wide>([&](auto i) HWY_ATTR { hn::Store(sum[i], floats, sums + first + i * lanes); });
  }
}

template <class N>
HWY_ATTR void add_hidden(const LeNetPlan& plan, const float* values, const std::uint32_t* rows, std::size_t count, float* sums) {
  with_hidden(plan, [&](const auto* weights) HWY_ATTR { add_rows<N::hidden_row>(weights, values, rows, count, sums); });
}

/// Adds the sum of a few inputs, so that rounding errors of thousands of inputs do not add up.
template <class N>
HWY_INLINE void end_sum(LeNetMemory& memory) {
  for (std::size_t i = 0; i < N::hidden_row; ++i) memory.hidden[i] += memory.row_sum[i];
  std::fill(memory.row_sum.begin(), memory.row_sum.end(), 0.0F);
}

/// Calls `take(column, vectors of channels)` for the outputs of a row of the second pooled layer that are computed, and
/// `end_group(first)` after each few of them.
template <class N, class Take, class EndGroup>
HWY_INLINE void second_row(const LeNetPlan& plan, const LeNetMemory& memory, std::size_t row, std::size_t count, Ahead& ahead,
                           const Take& take, const EndGroup& end_group) {
  constexpr std::size_t together = N::together, values = points * N::first_channels * block;
  const float* const base = &memory.at_points[2 * row * plan.blocks * values];
  for (std::size_t k = 0; k < count; k += together) {
    const float* in[together];
    std::uint32_t at[together];
    for (std::size_t i = 0; i < together; ++i) {
      at[i] = memory.columns[std::min(k + i, count - 1)];
      in[i] = base + at[i] / block * values + at[i] % block;
    }
    typename N::ChannelVector out[together * N::parts];
    second_at<N>(plan, in, ahead, out);
    for (std::size_t i = 0; i < together && k + i < count; ++i) take(at[i], out + i * N::parts);
    end_group(k == 0);
  }
}

/// The second convolution, interleaved with the contributions of its outputs to the first fully connected layer: while outputs
/// are computed, the weights of earlier ones are loaded into the cache.
template <class N>
HWY_ATTR void second_layer(const LeNetPlan& plan, LeNetMemory& memory, bool skip_empty, float* second) {
  constexpr typename N::Channels channels;
  const auto rows = static_cast<std::size_t>(plan.layers.second_pooled.height);
  const auto columns = static_cast<std::size_t>(plan.layers.second_pooled.width);
  Ahead ahead;
  if (second == nullptr) {
    with_hidden(plan, [&](const auto* weights) HWY_ATTR {
      ahead.weights = reinterpret_cast<const char*>(weights);
      ahead.row_bytes = N::hidden_row * sizeof(*weights);
    });
  }
  std::size_t turn = 0, appended = 0;
  ahead.rows = memory.rows[1].data();
  for (std::size_t row = 0; row < rows; ++row) {
    const auto take = [&](std::size_t column, const typename N::ChannelVector* out) HWY_ATTR {
      const std::size_t place = (row * columns + column) * N::second_channels;
      for (std::size_t part = 0; part < N::parts; ++part) {
        const std::size_t first = part * N::channel_lanes;
        const auto difference = hn::Sub(out[part], hn::Load(channels, &plan.second_empty[first]));
        if (second != nullptr) {
          hn::StoreU(difference, channels, second + place + first);
        } else {
          appended +=
              append<N>(difference, place + first, skip_empty, &memory.differences[turn][appended], &memory.rows[turn][appended]);
        }
      }
    };
    const auto end_group = [&](bool begins_row) HWY_ATTR {
      add_hidden<N>(plan, memory.differences[1 - turn].data(), ahead.rows, ahead.count, memory.row_sum.data());
      if (begins_row) end_sum<N>(memory);
      ahead.rows = memory.rows[turn].data();
      ahead.count = appended;
      turn = 1 - turn;
      appended = 0;
    };
    second_row<N>(plan, memory, row, columns_of(plan, memory, row, skip_empty), ahead, take, end_group);
  }
  add_hidden<N>(plan, memory.differences[1 - turn].data(), ahead.rows, ahead.count, memory.row_sum.data());
  end_sum<N>(memory);
}

/// The second convolution where the last pooling is of 4 x 4: two rows of the second pooled layer become one of the last.
template <class N>
HWY_ATTR void second_layer_pooled_by_4(const LeNetPlan& plan, LeNetMemory& memory, bool skip_empty, float* second) {
  constexpr typename N::Channels channels;
  const auto rows = static_cast<std::size_t>(plan.layers.last_pooled.height);
  const auto columns = static_cast<std::size_t>(plan.layers.last_pooled.width);
  Ahead nothing;
  for (std::size_t row = 0; row < rows; ++row) {
    std::fill(memory.last_computed.begin(), memory.last_computed.end(), std::uint8_t{0});
    const auto take = [&](std::size_t column, const typename N::ChannelVector* out) HWY_ATTR {
      if (column / 2 >= columns) return;
      const bool is_first = memory.last_computed[column / 2]++ == 0;
      for (std::size_t part = 0; part < N::parts; ++part) {
        float* const place = &memory.last_row[column / 2 * N::second_channels + part * N::channel_lanes];
        hn::Store(is_first ? out[part] : hn::Max(out[part], hn::Load(channels, place)), channels, place);
      }
    };
    for (std::size_t upper = 2 * row; upper < 2 * row + 2; ++upper)
      second_row<N>(plan, memory, upper, columns_of(plan, memory, upper, skip_empty), nothing, take, [](bool) {});
    for (std::size_t column = 0; column < columns; ++column) {
      if (memory.last_computed[column] == 0) continue;
      std::size_t appended = 0;
      for (std::size_t first = 0; first < N::second_channels; first += N::channel_lanes) {
        const std::size_t place = (row * columns + column) * N::second_channels + first;
        const auto empty = hn::Load(channels, &plan.second_empty[first]);
        auto largest = hn::Load(channels, &memory.last_row[column * N::second_channels + first]);
        if (memory.last_computed[column] < 4) largest = hn::Max(largest, empty);  // the others of its block are not computed
        const auto difference = hn::Sub(largest, empty);
        if (second != nullptr) {
          hn::StoreU(difference, channels, second + place);
        } else {
          appended += append<N>(difference, place, skip_empty, &memory.differences[0][appended], &memory.rows[0][appended]);
        }
      }
      add_hidden<N>(plan, memory.differences[0].data(), memory.rows[0].data(), appended, memory.row_sum.data());
    }
    end_sum<N>(memory);
  }
}

/// The rest: from the sums of the first fully connected layer to the logits.
template <class N>
HWY_ATTR void last_layers(const LeNetPlan& plan, LeNetMemory& memory, float* logits) {
  const Vector zero = hn::Zero(floats);
  for (std::size_t i = 0; i < N::hidden_row; i += lanes) {
    Vector sum = hn::Load(floats, &memory.hidden[i]);
    if (!plan.hidden_scale.empty()) sum = hn::Mul(sum, hn::Load(floats, &plan.hidden_scale[i]));
    hn::Store(hn::Max(hn::Add(sum, hn::Load(floats, &plan.hidden_empty[i])), zero), floats, &memory.hidden[i]);
  }
  constexpr std::size_t wide = std::min(std::size_t{8}, N::hidden_row / lanes);
  for (std::size_t first = 0; first < N::hidden_row; first += wide * lanes) {
    Vector sum[wide];
    each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::Load(floats, &plan.inner_bias[first + i * lanes]); });
    const float* weights = plan.inner_weights.data() + first;
    for (std::size_t k = 0; k < N::first_hidden; ++k, weights += N::hidden_row) {
      const Vector value = hn::Set(floats, memory.hidden[k]);
      each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::MulAdd(value, hn::Load(floats, weights + i * lanes), sum[i]); });
    }
    each<wide>([&](auto i) HWY_ATTR { hn::Store(hn::Max(sum[i], zero), floats, &memory.inner[first + i * lanes]); });
  }
  constexpr std::size_t chains = Sizes::chains;
  for (std::size_t part = 0; part < Sizes::lanes; part += lanes) {
    Vector sum[chains];
    each<chains>([&](auto i) HWY_ATTR { sum[i] = i == 0 ? hn::Load(floats, &plan.last_bias[part]) : zero; });
    for (std::size_t k = 0; k < N::second_hidden; k += chains) {  // beyond the last unit, weights and units are 0
      each<chains>([&](auto i) HWY_ATTR {
        sum[i] = hn::MulAdd(hn::Set(floats, memory.inner[k + i]),
                            hn::Load(floats, &plan.last_weights[(k + i) * Sizes::lanes + part]), sum[i]);
      });
    }
    hn::Store(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])), floats, &memory.last[part]);
  }
  for (std::size_t i = 0; i < Sizes::classes; ++i) logits[i] = memory.last[i] + 0.0F;  // -0 becomes 0
}

template <class N>
HWY_ATTR void run(const LeNetPlan& plan, LeNetMemory& memory, const std::uint8_t* heatmap, bool skip_empty, float* logits,
                  float* second) {
  if (!spread(plan, memory, heatmap, skip_empty) && skip_empty) {
    std::copy(plan.logits_empty.begin(), plan.logits_empty.end(), logits);
    return;
  }
  first_layer<N>(plan, memory, skip_empty);
  std::fill(memory.hidden.begin(), memory.hidden.end(), 0.0F);
  std::fill(memory.row_sum.begin(), memory.row_sum.end(), 0.0F);
  if (memory.last_row.empty()) {
    second_layer<N>(plan, memory, skip_empty, second);
  } else {
    second_layer_pooled_by_4<N>(plan, memory, skip_empty, second);
  }
  if (logits != nullptr) last_layers<N>(plan, memory, logits);
}

LeNetKernel kernel() { return {hwy::TargetName(HWY_TARGET), &run<Network<1>>, &run<Network<2>>, &run<Network<4>>}; }

}  // namespace

// The tables of the dispatch do not see into an unnamed namespace of another target.
LeNetKernel kernel_here() { return kernel(); }

}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::model {

HWY_EXPORT(kernel_here);

LeNetKernel best_kernel() { return HWY_DYNAMIC_DISPATCH(kernel_here)(); }

std::vector<LeNetKernel> kernels() {
  std::vector<LeNetKernel> all{best_kernel()};
  const auto add = [&all](const LeNetKernel& kernel) {
    if (std::string(kernel.name) != all.front().name) all.push_back(kernel);
  };
#if HWY_TARGETS & HWY_AVX3
  if ((hwy::SupportedTargets() & HWY_AVX3) != 0) add(N_AVX3::kernel_here());
#endif
#if HWY_TARGETS & HWY_AVX2
  if ((hwy::SupportedTargets() & HWY_AVX2) != 0) add(N_AVX2::kernel_here());
#endif
#if HWY_TARGETS & HWY_SSE4
  if ((hwy::SupportedTargets() & HWY_SSE4) != 0) add(N_SSE4::kernel_here());
#endif
#if HWY_STATIC_TARGET == HWY_SCALAR
  add(N_SCALAR::kernel_here());
#elif HWY_STATIC_TARGET == HWY_EMU128
  add(N_EMU128::kernel_here());
#elif defined(HWY_SSE2) && HWY_STATIC_TARGET == HWY_SSE2
  add(N_SSE2::kernel_here());
#endif
  return all;
}

LeNetMemory memory_for(const LeNetPlan& plan) {
  LeNetMemory memory;
  const std::size_t pairs = plan.input_rows * plan.pair_stride, chunks = plan.input_rows / 2 * plan.pair_chunks;
  memory.even.resize(pairs);
  memory.odd.resize(pairs);
  memory.lit.resize(pairs / 2);
  memory.lit_chunk.resize(chunks);
  memory.lit_row.resize(plan.pair_stride);
  const auto rows = static_cast<std::size_t>(plan.layers.first_pooled.height);
  memory.pooled.resize(rows * plan.layers.first_channels * plan.pooled_stride);
  memory.at_points.resize(rows * plan.blocks * LeNetSizes::points * plan.layers.first_channels * LeNetSizes::block);
  memory.computed.assign(chunks, 1);  // so that what is not computed is set to an empty heatmap's
  memory.columns.resize(static_cast<std::size_t>(plan.layers.second_pooled.width) + 1);
  if (plan.layers.last_pooled.width < plan.layers.second_pooled.width) {
    const auto columns = static_cast<std::size_t>(plan.layers.last_pooled.width);
    memory.last_row.resize(columns * plan.layers.second_channels);
    memory.last_computed.resize(columns);
  }
  constexpr std::size_t most_together = 6, room = (most_together + 1) * SizesOf<4>::second_channels;
  for (auto& differences : memory.differences) differences.resize(room);
  for (auto& rows_of : memory.rows) rows_of.resize(room);
  for (AlignedValues<float>* row : {&memory.hidden, &memory.row_sum, &memory.inner}) row->resize(plan.hidden_row);
  memory.last.resize(LeNetSizes::lanes);
  return memory;
}

}  // namespace tactile::model
#endif
