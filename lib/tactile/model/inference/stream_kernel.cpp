// Compiled once for each set of vector instructions: foreach_target.h reads this file again for each.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/inference/stream_kernel.cpp"
#include "tactile/model/inference/stream_kernel.hpp"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

constexpr std::size_t channels = StreamSizes::channels, places = StreamLayout::places, memory = StreamSizes::memory;
constexpr std::size_t span_count = StreamSizes::spans.size();

template <std::size_t count>
struct alignas(cache_line) Values : std::array<float, count> {};

/// sums += values * weights, [inputs, outputs]. An input of 0, as after most ReLUs, adds nothing.
template <std::size_t outputs>
HWY_INLINE void add_products(const float* values, std::size_t inputs, const float* weights, float* sums) {
  for (std::size_t in = 0; in < inputs; ++in) {
    const float value = values[in];
    if (value == 0) continue;
    const float* row = weights + in * outputs;
    for (std::size_t out = 0; out < outputs; ++out) sums[out] += value * row[out];
  }
}

HWY_INLINE void relu(float* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = std::max(values[i], 0.0F);
}

HWY_INLINE float log1p_of(const StreamPlan& plan, std::uint32_t count) {
  return count < plan.log1p.size() ? plan.log1p[count] : std::log1p(static_cast<float>(count));
}

/// a_p of all places.
HWY_INLINE void first_layer(const StreamPlan& plan, const StreamCounts& counts, Values<places * channels>& values) {
  std::array<std::uint32_t, places> events{};
  for (std::size_t place = 0; place < places; ++place)
    std::copy(plan.cells_bias.begin(), plan.cells_bias.end(), values.begin() + place * channels);
  for (const std::uint16_t cell : counts.touched()) {
    const std::size_t place = cell / StreamLayout::cells_of_place, of_place = cell % StreamLayout::cells_of_place;
    const std::uint32_t count = counts.at(cell);
    events[place] += count;
    const float value = log1p_of(plan, count);
    add_products<channels>(&value, 1, plan.cells.data() + of_place * channels, values.data() + place * channels);
  }
  for (std::size_t place = 0; place < places; ++place) {
    const float value = log1p_of(plan, events[place]);
    add_products<channels>(&value, 1, plan.cells_all.data(), values.data() + place * channels);
  }
  relu(values.data(), values.size());
}

/// Moves the running means on. @return  the largest change of one
HWY_INLINE float update_means(const Values<places * channels>& values, float* means) {
  float most = 0;
  for (std::size_t span = 0; span < span_count; ++span) {
    const auto added = static_cast<float>(1 / StreamSizes::spans[span]),
               kept = static_cast<float>(1 - 1 / StreamSizes::spans[span]);
    float* of_span = means + span * places * channels;
    for (std::size_t i = 0; i < places * channels; ++i) {
      const float next = kept * of_span[i] + added * values[i];
      most = std::max(most, std::abs(next - of_span[i]));
      of_span[i] = next;
    }
  }
  return most;
}

/// v of all places.
HWY_INLINE void pool_places(const StreamPlan& plan, const Values<places * channels>& values, const float* means,
                            Values<StreamSizes::pooled>& pooled) {
  std::fill(pooled.begin(), pooled.end(), 0.0F);
  constexpr float share = 1.0F / static_cast<float>(places);
  for (std::size_t place = 0; place < places; ++place) {
    Values<channels> hidden, out;
    std::copy(plan.means_bias.begin(), plan.means_bias.end(), hidden.begin());
    add_products<channels>(values.data() + place * channels, channels, plan.means.data(), hidden.data());
    for (std::size_t span = 0; span < span_count; ++span)
      add_products<channels>(means + (span * places + place) * channels, channels,
                             plan.means.data() + (span + 1) * channels * channels, hidden.data());
    relu(hidden.data(), channels);
    std::copy(plan.place_bias.begin(), plan.place_bias.end(), out.begin());
    add_products<channels>(hidden.data(), channels, plan.place.data(), out.data());
    relu(out.data(), channels);
    const float x = share * position_of(place % StreamLayout::across, StreamLayout::across);
    const float y = share * position_of(place / StreamLayout::across, StreamLayout::down);
    for (std::size_t i = 0; i < channels; ++i) {
      pooled[i] += share * out[i];
      pooled[channels + i] = std::max(pooled[channels + i], out[i]);
      pooled[2 * channels + i] += x * out[i];
      pooled[3 * channels + i] += y * out[i];
    }
  }
}

HWY_INLINE float sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

/// @return  the largest change of a unit
HWY_INLINE float update_memory(const StreamPlan& plan, const Values<StreamSizes::pooled>& pooled, float* units) {
  Values<3 * memory> input, own;
  std::copy(plan.gru_input_bias.begin(), plan.gru_input_bias.end(), input.begin());
  std::copy(plan.gru_memory_bias.begin(), plan.gru_memory_bias.end(), own.begin());
  add_products<3 * memory>(pooled.data(), pooled.size(), plan.gru_input.data(), input.data());
  add_products<3 * memory>(units, memory, plan.gru_memory.data(), own.data());
  float most = 0;
  for (std::size_t i = 0; i < memory; ++i) {
    const float reset = sigmoid(input[i] + own[i]), update = sigmoid(input[memory + i] + own[memory + i]);
    const float fresh = std::tanh(input[2 * memory + i] + reset * own[2 * memory + i]);
    const float next = (1 - update) * fresh + update * units[i];
    most = std::max(most, std::abs(next - units[i]));
    units[i] = next;
  }
  return most;
}

void advance_tick(const StreamPlan& plan, const StreamCounts& counts, StreamState& state) {
  Values<places * channels> values;
  Values<StreamSizes::pooled> pooled;
  first_layer(plan, counts, values);
  const float moved = update_means(values, state.means.data());
  pool_places(plan, values, state.means.data(), pooled);
  const float changed = update_memory(plan, pooled, state.memory.data());
  std::array<float, 4> sums{};
  std::copy(plan.out_bias.begin(), plan.out_bias.end(), sums.begin());
  add_products<4>(state.memory.data(), memory, plan.out.data(), sums.data());
  std::copy_n(sums.begin(), state.logits.size(), state.logits.begin());
  state.at_rest = counts.touched().empty() && std::max(moved, changed) <= StreamNetwork::rest;
}

}  // namespace
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::model {

HWY_EXPORT(advance_tick);

void advance_stream(const StreamPlan& plan, const StreamCounts& counts, StreamState& state) {
  HWY_DYNAMIC_DISPATCH(advance_tick)(plan, counts, state);
}

}  // namespace tactile::model
#endif
