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
HWY_INLINE std::size_t append(Vector difference, std::size_t row, bool skip_empty, float* differences, std::uint32_t* rows) {
  const hn::RebindToUnsigned<Floats> numbers;
  const auto own_rows = hn::Iota(numbers, static_cast<std::uint32_t>(row));
  if (!skip_empty) {
    hn::StoreU(difference, floats, differences);
    hn::StoreU(own_rows, numbers, rows);
    return lanes;
  }
  const auto other = hn::Ne(difference, hn::Zero(floats));
  hn::StoreU(hn::Compress(difference, other), floats, differences);
  hn::StoreU(hn::Compress(own_rows, hn::RebindMask(numbers, other)), numbers, rows);
  return hn::CountTrue(floats, other);
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
template <class Weight>
HWY_INLINE void add_rows(const Weight* weights, const float* values, const std::uint32_t* rows, std::size_t count, float* sums) {
  constexpr std::size_t wide = 8;
  for (std::size_t first = 0; first < hidden_row; first += wide * lanes) {
    Vector sum[wide];
    each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::Load(floats, sums + first + i * lanes); });
    for (std::size_t k = 0; k < count; ++k) {
      const Vector value = hn::Set(floats, values[k]);
      const Weight* of_row = weights + static_cast<std::size_t>(rows[k]) * hidden_row + first;
      each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::MulAdd(value, weights_at(of_row + i * lanes), sum[i]); });
    }
    each<wide>([&](auto i) HWY_ATTR { hn::Store(sum[i], floats, sums + first + i * lanes); });
  }
}

HWY_ATTR void add_hidden(const LeNetPlan& plan, const float* values, const std::uint32_t* rows, std::size_t count, float* sums) {
  with_hidden(plan, [&](const auto* weights) HWY_ATTR { add_rows(weights, values, rows, count, sums); });
}

/// The second convolution, interleaved with the contributions of its outputs to the first fully connected layer: while outputs
/// are computed, the weights of earlier ones are loaded into the cache.
HWY_ATTR void second_layer(const LeNetPlan& plan, LeNetMemory& memory, bool skip_empty, float* second) {
  const auto rows = static_cast<std::size_t>(plan.layers.second_pooled.height);
  const auto columns = static_cast<std::size_t>(plan.layers.second_pooled.width);
  std::fill(memory.hidden.begin(), memory.hidden.end(), 0.0F);
  std::fill(memory.row_sum.begin(), memory.row_sum.end(), 0.0F);
  Ahead ahead;
  if (second == nullptr) {
    with_hidden(plan, [&](const auto* weights) HWY_ATTR {
      ahead.weights = reinterpret_cast<const char*>(weights);
      ahead.row_bytes = hidden_row * sizeof(*weights);
    });
  }
  const auto end_row = [&]() HWY_ATTR {
    for (std::size_t i = 0; i < hidden_row; ++i) memory.hidden[i] += memory.row_sum[i];
    std::fill(memory.row_sum.begin(), memory.row_sum.end(), 0.0F);
  };
  std::size_t turn = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t count = columns_of(plan, memory, row, skip_empty);
    const float* const base = &memory.at_points[2 * row * plan.blocks * points * first_channels * block];
    for (std::size_t k = 0; k < count; k += together) {
      const float* in[together];
      std::uint32_t at[together];
      for (std::size_t i = 0; i < together; ++i) {
        at[i] = memory.columns[std::min(k + i, count - 1)];
        in[i] = base + at[i] / block * points * first_channels * block + at[i] % block;
      }
      Vector out[together * parts];
      ahead.rows = memory.rows[1 - turn].data();
      second_at(plan, in, ahead, out);
      std::size_t appended = 0;
      for (std::size_t i = 0; i < together && k + i < count; ++i) {
        const std::size_t place = (row * columns + at[i]) * Sizes::second_channels;
        for (std::size_t part = 0; part < parts; ++part) {
          const Vector difference = hn::Sub(out[i * parts + part], hn::Load(floats, &plan.second_empty[part * lanes]));
          if (second != nullptr) {
            hn::StoreU(difference, floats, second + place + part * lanes);
          } else {
            appended += append(difference, place + part * lanes, skip_empty, &memory.differences[turn][appended],
                               &memory.rows[turn][appended]);
          }
        }
      }
      add_hidden(plan, memory.differences[1 - turn].data(), ahead.rows, ahead.count, memory.row_sum.data());
      if (k == 0) end_row();
      ahead.count = appended;
      turn = 1 - turn;
    }
  }
  add_hidden(plan, memory.differences[1 - turn].data(), memory.rows[1 - turn].data(), ahead.count, memory.row_sum.data());
  end_row();
}

/// The rest: from the sums of the first fully connected layer to the logits.
HWY_ATTR void last_layers(const LeNetPlan& plan, LeNetMemory& memory, float* logits) {
  const Vector zero = hn::Zero(floats);
  for (std::size_t i = 0; i < hidden_row; i += lanes) {
    Vector sum = hn::Load(floats, &memory.hidden[i]);
    if (!plan.hidden_scale.empty()) sum = hn::Mul(sum, hn::Load(floats, &plan.hidden_scale[i]));
    hn::Store(hn::Max(hn::Add(sum, hn::Load(floats, &plan.hidden_empty[i])), zero), floats, &memory.hidden[i]);
  }
  constexpr std::size_t wide = 8;
  for (std::size_t first = 0; first < hidden_row; first += wide * lanes) {
    Vector sum[wide];
    each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::Load(floats, &plan.inner_bias[first + i * lanes]); });
    const float* weights = plan.inner_weights.data() + first;
    for (std::size_t k = 0; k < Sizes::first_hidden; ++k, weights += hidden_row) {
      const Vector value = hn::Set(floats, memory.hidden[k]);
      each<wide>([&](auto i) HWY_ATTR { sum[i] = hn::MulAdd(value, hn::Load(floats, weights + i * lanes), sum[i]); });
    }
    each<wide>([&](auto i) HWY_ATTR { hn::Store(hn::Max(sum[i], zero), floats, &memory.inner[first + i * lanes]); });
  }
  constexpr std::size_t chains = 4;  // independent chains of sums
  for (std::size_t part = 0; part < Sizes::lanes; part += lanes) {
    Vector sum[chains];
    each<chains>([&](auto i) HWY_ATTR { sum[i] = i == 0 ? hn::Load(floats, &plan.last_bias[part]) : zero; });
    for (std::size_t k = 0; k < Sizes::second_hidden; k += chains) {
      each<chains>([&](auto i) HWY_ATTR {
        sum[i] = hn::MulAdd(hn::Set(floats, memory.inner[k + i]),
                            hn::Load(floats, &plan.last_weights[(k + i) * Sizes::lanes + part]), sum[i]);
      });
    }
    hn::Store(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])), floats, &memory.last[part]);
  }
  for (std::size_t i = 0; i < Sizes::classes; ++i) logits[i] = memory.last[i] + 0.0F;  // -0 becomes 0
}

HWY_ATTR void run(const LeNetPlan& plan, LeNetMemory& memory, const std::uint8_t* heatmap, bool skip_empty, float* logits,
                  float* second) {
  if (!spread(plan, memory, heatmap, skip_empty) && skip_empty) {
    std::copy(plan.logits_empty.begin(), plan.logits_empty.end(), logits);
    return;
  }
  first_layer(plan, memory, skip_empty);
  second_layer(plan, memory, skip_empty, second);
  if (logits != nullptr) last_layers(plan, memory, logits);
}

LeNetKernel kernel() { return {hwy::TargetName(HWY_TARGET), &run}; }

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
  memory.pooled.resize(rows * LeNetSizes::first_channels * plan.pooled_stride);
  memory.at_points.resize(rows * plan.blocks * LeNetSizes::points * LeNetSizes::first_channels * LeNetSizes::block);
  memory.computed.assign(chunks, 1);  // so that what is not computed is set to an empty heatmap's
  memory.columns.resize(static_cast<std::size_t>(plan.layers.second_pooled.width) + 1);
  constexpr std::size_t most_together = 6, room = (most_together + 1) * LeNetSizes::second_channels;
  for (auto& differences : memory.differences) differences.resize(room);
  for (auto& rows_of : memory.rows) rows_of.resize(room);
  for (AlignedValues<float>* row : {&memory.hidden, &memory.row_sum, &memory.inner}) row->resize(LeNetSizes::hidden_row);
  memory.last.resize(LeNetSizes::lanes);
  return memory;
}

}  // namespace tactile::model
#endif
