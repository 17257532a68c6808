#include "tactile/model/inference/stream_network.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/model/inference/flushed_denormals.hpp"
#include "tactile/model/inference/stream_kernel.hpp"

namespace tactile::model {
namespace {

/// [outputs, inputs] as [inputs, row], where a row has the outputs from `first` input on, then zeros.
AlignedValues<float> side_by_side(const Parameter& parameter, std::size_t first, std::size_t count, std::size_t row) {
  const auto outputs = static_cast<std::size_t>(parameter.shape.sizes[0]),
             inputs = static_cast<std::size_t>(parameter.shape.sizes[1]);
  AlignedValues<float> moved(count * row);
  for (std::size_t out = 0; out < outputs; ++out) {
    for (std::size_t in = 0; in < count; ++in) moved[in * row + out] = parameter.values[out * inputs + first + in];
  }
  return moved;
}

AlignedValues<float> side_by_side(const Parameter& parameter) {
  return side_by_side(parameter, 0, static_cast<std::size_t>(parameter.shape.sizes[1]),
                      static_cast<std::size_t>(parameter.shape.sizes[0]));
}

AlignedValues<float> padded(const Parameter& bias, std::size_t count) {
  AlignedValues<float> values(count);
  std::copy(bias.values.begin(), bias.values.end(), values.begin());
  return values;
}

/// The largest output of a layer whose inputs are at most `largest`. @throws Error  if float32 may not hold it
double largest_after(const Parameter& weights, const Parameter& bias, double largest) {
  constexpr double most = 1e37;
  const auto inputs = static_cast<std::size_t>(weights.shape.sizes[1]);
  double after = 0;
  for (std::size_t out = 0; out < bias.values.size(); ++out) {
    double sum = std::abs(static_cast<double>(bias.values[out]));
    for (std::size_t in = 0; in < inputs; ++in) sum += std::abs(static_cast<double>(weights.values[out * inputs + in])) * largest;
    after = std::max(after, sum);
  }
  if (!(after <= most))
    throw Error(
        fmt::format("{}: a sum may reach {:.3g}; expected {:.0g} at most, of smaller weights", weights.shape.name, after, most));
  return after;
}

}  // namespace

StreamGrid grid_of(const Weights& weights) {
  const std::vector<float>& sides = weights.front().values;
  return {static_cast<double>(sides[0]), static_cast<double>(sides[1]), static_cast<double>(sides[2]),
          static_cast<double>(sides[3])};
}

StreamNetwork::StreamNetwork(const Weights& weights) {
  check_shapes(weights, stream_parameters(), "a model of kind stream with other parameters");
  grid_ = grid_of(weights);
  check(grid_);
  const double largest_log = std::log1p(4e9);
  const double of_place = largest_after(
      weights[5], weights[6], largest_after(weights[3], weights[4], largest_after(weights[1], weights[2], largest_log)));
  largest_after(weights[7], weights[9], of_place);
  largest_after(weights[8], weights[10], 1);
  largest_after(weights[11], weights[12], 1);
  constexpr std::size_t channels = StreamSizes::channels, cells = StreamLayout::cells_of_place;
  plan_ = {.cells = side_by_side(weights[1], 0, cells, channels),
           .cells_all = side_by_side(weights[1], cells, 1, channels),
           .cells_bias = padded(weights[2], channels),
           .means = side_by_side(weights[3]),
           .means_bias = padded(weights[4], channels),
           .place = side_by_side(weights[5]),
           .place_bias = padded(weights[6], channels),
           .gru_input = side_by_side(weights[7]),
           .gru_input_bias = padded(weights[9], weights[9].values.size()),
           .gru_memory = side_by_side(weights[8]),
           .gru_memory_bias = padded(weights[10], weights[10].values.size()),
           .out = side_by_side(weights[11], 0, StreamSizes::memory, 4),
           .out_bias = padded(weights[12], 4)};
  for (std::size_t n = 0; n < plan_.log1p.size(); ++n) plan_.log1p[n] = std::log1p(static_cast<float>(n));
}

void StreamNetwork::advance(const StreamCounts& counts, StreamState& state) const {
  if (state.at_rest && counts.touched().empty()) return;
  const FlushedDenormals flushed;
  advance_stream(plan_, counts, state);
}

}  // namespace tactile::model
