#include "tactile/evaluation/feature_network.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/training/fully_connected.hpp"
#include "tactile/model/training/optimizer_steps.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t hidden = 32, batch_size = 256, passes = 10;

using Arrays = std::vector<std::vector<float>>;

/// The rows of `all` with these places.
std::vector<float> rows_of(std::span<const float> all, std::size_t size, std::span<const std::size_t> places) {
  std::vector<float> rows;
  for (const std::size_t place : places) {
    const std::span<const float> row = all.subspan(place * size, size);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  return rows;
}

/// Of the mean cross-entropy by the logits, (p - [class is true]) / n.
std::vector<float> gradient_of(std::span<const float> logits, std::span<const Touch> truth, std::span<const std::size_t> places) {
  std::vector<float> gradient;
  for (std::size_t i = 0; i < places.size(); ++i) {
    model::Logits of{};
    std::copy_n(logits.begin() + static_cast<std::ptrdiff_t>(i * touch_count), touch_count, of.begin());
    const model::Probabilities p = model::probabilities_of(of);
    for (std::size_t c = 0; c < touch_count; ++c) {
      const bool is_true = c == static_cast<std::size_t>(truth[places[i]]);
      gradient.push_back((p[c] - (is_true ? 1.0F : 0.0F)) / static_cast<float>(places.size()));
    }
  }
  return gradient;
}

}  // namespace

FeatureNetwork::FeatureNetwork(std::span<const float> features, std::size_t size, std::span<const Touch> truth) : size_(size) {
  if (truth.empty() || size == 0 || features.size() != truth.size() * size)
    throw Error("network on features: no sample, or not the same number of features for each; expected some");
  const auto count = static_cast<double>(truth.size());
  for (std::size_t i = 0; i < size; ++i) {
    double sum = 0, squares = 0;
    for (std::size_t n = 0; n < truth.size(); ++n) sum += features[n * size + i];
    for (std::size_t n = 0; n < truth.size(); ++n) squares += std::pow(features[n * size + i] - sum / count, 2);
    mean_.push_back(static_cast<float>(sum / count));
    deviation_.push_back(squares > 0 ? static_cast<float>(std::sqrt(squares / count)) : 1.0F);
  }
  Random random(1);
  for (const auto& [inputs, units] : {std::pair(size, hidden), std::pair(hidden, hidden), std::pair(hidden, touch_count)}) {
    Layer layer{inputs, units, std::vector<float>((inputs + 1) * units)};
    const double bound = 1 / std::sqrt(static_cast<double>(inputs));
    for (float& weight : layer.weights) weight = static_cast<float>(random.uniform(-bound, bound));
    layers_.push_back(std::move(layer));
  }
  train(standardised(features), truth, random);
}

void FeatureNetwork::train(std::span<const float> features, std::span<const Touch> truth, Random& random) {
  Arrays gradients;
  for (const Layer& layer : layers_) gradients.emplace_back(layer.weights.size());
  Arrays first = gradients, second = gradients;
  std::vector<std::size_t> order(truth.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  model::OptimizerStep step{.step = 0};
  for (std::size_t pass = 0; pass < passes; ++pass) {
    random.shuffle(order);
    for (std::size_t begin = 0; begin < order.size(); begin += batch_size) {
      const std::span<const std::size_t> places = std::span(order).subspan(begin, std::min(batch_size, order.size() - begin));
      const std::vector<float> input = rows_of(features, size_, places);
      const Arrays outputs = outputs_of(input);
      propagate_back(input, outputs, gradient_of(outputs.back(), truth, places), gradients);
      ++step.step;
      for (std::size_t at = 0; at < layers_.size(); ++at)
        model::take_step(step, {layers_[at].weights, gradients[at], first[at], second[at]});
    }
  }
}

void FeatureNetwork::propagate_back(const std::vector<float>& input, const Arrays& outputs, std::vector<float> gradient,
                                    Arrays& gradients) const {
  const std::size_t n = input.size() / size_;
  for (std::size_t at = layers_.size(); at-- > 0;) {
    const Layer& layer = layers_[at];
    const std::vector<float>& below = at == 0 ? input : outputs[at - 1];
    const std::size_t weights = layer.inputs * layer.units;
    std::vector<float> of_input(n * layer.inputs);
    model::FullyConnected(layer.inputs, layer.units)
        .backward(below, std::span(layer.weights).first(weights), gradient, of_input, std::span(gradients[at]).first(weights), 1);
    for (std::size_t unit = 0; unit < layer.units; ++unit) {
      float sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += gradient[i * layer.units + unit];
      gradients[at][weights + unit] = sum;
    }
    for (std::size_t i = 0; at > 0 && i < of_input.size(); ++i) of_input[i] = below[i] > 0 ? of_input[i] : 0.0F;
    gradient = std::move(of_input);
  }
}

std::vector<float> FeatureNetwork::standardised(std::span<const float> features) const {
  std::vector<float> values(features.begin(), features.end());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = (values[i] - mean_[i % size_]) / deviation_[i % size_];
  return values;
}

/// After ReLU, except for the logits.
std::vector<std::vector<float>> FeatureNetwork::outputs_of(std::span<const float> batch) const {
  const std::size_t n = batch.size() / size_;
  std::vector<std::vector<float>> outputs;
  for (const Layer& layer : layers_) {
    const std::size_t weights = layer.inputs * layer.units;
    std::vector<float> output(n * layer.units);
    model::FullyConnected(layer.inputs, layer.units)
        .forward(outputs.empty() ? batch : std::span<const float>(outputs.back()), std::span(layer.weights).first(weights),
                 std::span(layer.weights).subspan(weights), output, 1);
    const bool is_last = &layer == &layers_.back();
    if (!is_last) std::transform(output.begin(), output.end(), output.begin(), [](float value) { return std::max(value, 0.0F); });
    outputs.push_back(std::move(output));
  }
  return outputs;
}

std::vector<model::Probabilities> FeatureNetwork::predict(std::span<const float> features) const {
  std::vector<model::Probabilities> probabilities;
  if (features.empty()) return probabilities;
  const std::vector<float> logits = outputs_of(standardised(features)).back();
  for (std::size_t i = 0; i < logits.size(); i += touch_count) {
    model::Logits of{};
    std::copy_n(logits.begin() + static_cast<std::ptrdiff_t>(i), touch_count, of.begin());
    probabilities.push_back(model::probabilities_of(of));
  }
  return probabilities;
}

}  // namespace tactile::evaluation
