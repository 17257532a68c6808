#include "tactile/model/inference/temporal_network.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/model/inference/flushed_denormals.hpp"

namespace tactile::model {
namespace {

constexpr std::size_t most_channels = 64;

/// [outputs, inputs, taps] as [taps * inputs, outputs].
std::vector<float> side_by_side(const std::vector<float>& weights, std::size_t outputs, std::size_t inputs, std::size_t taps) {
  std::vector<float> moved(weights.size());
  for (std::size_t out = 0; out < outputs; ++out) {
    for (std::size_t in = 0; in < inputs; ++in) {
      for (std::size_t tap = 0; tap < taps; ++tap)
        moved[(tap * inputs + in) * outputs + out] = weights[(out * inputs + in) * taps + tap];
    }
  }
  return moved;
}

/// sums = bias + weights * values, with [values.size(), sums.size()] weights.
void multiply(std::span<const float> values, const float* weights, std::span<const float> bias, std::span<float> sums) {
  std::copy(bias.begin(), bias.end(), sums.begin());
  const std::size_t outputs = sums.size();
  for (const float value : values) {
    for (std::size_t i = 0; i < outputs; ++i) sums[i] += value * weights[i];
    weights += outputs;
  }
}

}  // namespace

void standardise(std::span<const float> features, std::span<const float> mean, std::span<const float> scale,
                 std::span<float> values) {
  for (std::size_t i = 0; i < features.size(); ++i) {
    const std::size_t k = i % mean.size();
    values[i] = std::clamp((features[i] - mean[k]) * scale[k], -largest_step_value, largest_step_value);
  }
}

TemporalNetwork::TemporalNetwork(const TemporalOptions& options, const Weights& weights) {
  check(options);
  check_shapes(weights, temporal_parameters(options), "a temporal convolution with other parameters than its settings");
  mean_ = weights[0].values;
  scale_ = weights[1].values;
  std::size_t inputs = features::features_of_step, next = 2;
  for (Layer& layer : layers_) {
    layer = {inputs, options.channels, side_by_side(weights[next].values, options.channels, inputs, 2), weights[next + 1].values};
    inputs = options.channels;
    next += 2;
  }
  out_ = {inputs, touch_count, side_by_side(weights[next].values, touch_count, inputs, 1), weights[next + 1].values};
  check_range();
}

void TemporalNetwork::check_range() const {
  constexpr double most = 1e37;
  double largest = static_cast<double>(largest_step_value);
  const auto pass = [&](const Layer& layer) {
    double next = 0;
    for (std::size_t out = 0; out < layer.outputs; ++out) {
      double sum = std::abs(static_cast<double>(layer.bias[out]));
      for (std::size_t i = out; i < layer.weights.size(); i += layer.outputs)
        sum += std::abs(static_cast<double>(layer.weights[i])) * largest;
      next = std::max(next, sum);
    }
    largest = next;
    if (!(largest <= most))
      throw Error(fmt::format("a temporal convolution whose sums may reach {:.3g}; expected {:.0g} at most, of smaller weights",
                              largest, most));
  };
  for (const Layer& layer : layers_) pass(layer);
  pass(out_);
}

Logits TemporalNetwork::logits(std::span<const float> features) const {
  if (features.size() != features::step_values)
    throw Error(fmt::format("{} features of steps; expected {}", features.size(), features::step_values));
  constexpr std::size_t most_values = std::max(features::step_values, features::steps_of_history / 2 * most_channels);
  const FlushedDenormals flushed;
  std::array<float, most_values> one{}, other{};
  std::span<float> from = one, to = other;
  standardise(features, mean_, scale_, from);
  std::size_t steps = features::steps_of_history;
  for (const Layer& layer : layers_) {
    // The outputs that the last one needs are two steps of the layer's inputs each, one pair after the other.
    steps /= 2;
    const std::size_t pair = 2 * layer.inputs;
    for (std::size_t k = 0; k < steps; ++k) {
      const std::span<float> sums = to.subspan(k * layer.outputs, layer.outputs);
      multiply(from.subspan(k * pair, pair), layer.weights.data(), layer.bias, sums);
      for (float& sum : sums) sum = std::max(sum, 0.0F);
    }
    std::swap(from, to);
  }
  Logits logits{};
  multiply(from.first(out_.inputs), out_.weights.data(), out_.bias, logits);
  return logits;
}

}  // namespace tactile::model
