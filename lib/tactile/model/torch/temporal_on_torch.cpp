#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/features/step_features.hpp"
#include "tactile/model/inference/temporal_network.hpp"
#include "tactile/model/torch/torch_part.hpp"
#include "tactile/model/torch/torch_training.hpp"

namespace tactile::model {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto values_of_step = static_cast<std::int64_t>(features::features_of_step);
constexpr auto steps = static_cast<std::int64_t>(features::steps_of_history);

/// The layers as convolutions that take every second step: the outputs that the last output of the dilated ones needs.
struct TemporalModule : torch::nn::Module {
  explicit TemporalModule(const TemporalOptions& options) : out(options.channels, static_cast<std::int64_t>(touch_count)) {
    std::int64_t inputs = values_of_step;
    for (std::size_t layer = 1; layer <= temporal_layers; ++layer) {
      convolutions.emplace_back(torch::nn::Conv1dOptions(inputs, options.channels, 2).stride(2));
      register_module(fmt::format("conv{}", layer), convolutions.back());
      inputs = options.channels;
    }
    register_module("out", out);
  }
  torch::Tensor forward(torch::Tensor x) {
    for (torch::nn::Conv1d& convolution : convolutions) x = torch::relu(convolution->forward(x));
    return out->forward(x.squeeze(2));
  }

  std::vector<torch::nn::Conv1d> convolutions;
  torch::nn::Linear out;
};

/// [samples, 12, 16] of standardised values.
torch::Tensor inputs_of(std::span<const float> features, std::span<const float> mean, std::span<const float> scale) {
  const auto samples = static_cast<std::int64_t>(features.size() / features::step_values);
  const torch::Tensor by_step = torch::empty({samples, steps, values_of_step});
  standardise(features, mean, scale, {by_step.data_ptr<float>(), features.size()});
  return by_step.transpose(1, 2).contiguous();
}

/// Mean and 1 / deviation of each feature over all steps of the samples; a feature that never varies has a scale of 1.
std::array<std::vector<float>, 2> standard_of(std::span<const float> features) {
  std::array<std::vector<float>, 2> standard{std::vector<float>(features::features_of_step),
                                             std::vector<float>(features::features_of_step)};
  const std::size_t steps_in_all = features.size() / features::features_of_step;
  const auto n = static_cast<double>(steps_in_all);
  for (std::size_t k = 0; k < features::features_of_step; ++k) {
    double sum = 0, squares = 0;
    for (std::size_t i = k; i < features.size(); i += features::features_of_step) sum += static_cast<double>(features[i]);
    const double mean = sum / n;
    for (std::size_t i = k; i < features.size(); i += features::features_of_step)
      squares += (static_cast<double>(features[i]) - mean) * (static_cast<double>(features[i]) - mean);
    const double deviation = std::sqrt(squares / n);
    standard[0][k] = static_cast<float>(mean);
    standard[1][k] = deviation > 1e-6 * (1 + std::abs(mean)) ? static_cast<float>(1 / deviation) : 1.0F;
  }
  return standard;
}

void set_rate(torch::optim::Optimizer& optimizer, OptimizerKind kind, double rate) {
  for (torch::optim::OptimizerParamGroup& group : optimizer.param_groups()) {
    if (kind == OptimizerKind::adam) static_cast<torch::optim::AdamOptions&>(group.options()).lr(rate);
    if (kind == OptimizerKind::adamw) static_cast<torch::optim::AdamWOptions&>(group.options()).lr(rate);
    if (kind == OptimizerKind::sgd) static_cast<torch::optim::SGDOptions&>(group.options()).lr(rate);
  }
}

void check_input(std::span<const float> features, std::span<const Touch> truth) {
  if (truth.empty() || features.size() != truth.size() * features::step_values)
    throw Error(
        fmt::format("training a temporal convolution: {} features of {} samples; expected a sample at least, and {} for each",
                    features.size(), truth.size(), features::step_values));
  if (!std::all_of(features.begin(), features.end(), [](float feature) { return std::isfinite(feature); }))
    throw Error("training a temporal convolution: a feature is not finite; expected finite ones");
}

/// The samples, ready for libtorch, and what one pass over them changes.
struct Training {
  TemporalModule& network;
  torch::Tensor inputs, targets, class_weights;
  const TrainingOptions& options;
  std::unique_ptr<torch::optim::Optimizer> optimizer;
  std::int64_t samples;

  EpochResult pass(unsigned number) {
    const auto begun = Clock::now();
    std::vector<std::int64_t> order(static_cast<std::size_t>(samples));
    std::iota(order.begin(), order.end(), 0);
    Random random(seed_for(options.seed, {"order", std::to_string(number)}));
    random.shuffle(order);
    const std::uint64_t batch = options.batch, count = order.size(), batches = (count + batch - 1) / batch;
    EpochResult epoch;
    epoch.epoch = number;
    double loss_sum = 0, weight_sum = 0, correct = 0;
    for (std::uint64_t first = 0, step = (number - 1) * batches; first < count; first += batch, ++step) {
      const auto size = static_cast<std::int64_t>(std::min(batch, count - first));
      const torch::Tensor chosen = torch::from_blob(order.data() + first, {size}, torch::kInt64);
      const torch::Tensor truth = targets.index_select(0, chosen);
      epoch.learning_rate = learning_rate_at(options, step, batches * options.epochs);
      set_rate(*optimizer, options.optimizer, epoch.learning_rate);
      optimizer->zero_grad();
      const torch::Tensor logits = network.forward(inputs.index_select(0, chosen));
      const torch::Tensor loss = torch::nn::functional::cross_entropy(
          logits, truth, torch::nn::functional::CrossEntropyFuncOptions().weight(class_weights));
      loss.backward();
      const auto norm = torch::nn::utils::clip_grad_norm_(network.parameters(), 1e6);
      const auto value = loss.item<double>();
      if (!std::isfinite(value) || !std::isfinite(norm)) {
        throw Error(fmt::format("training: the loss is {} in epoch {}; expected a finite one (try a smaller --lr than {})", value,
                                number, options.learning_rate));
      }
      epoch.gradient_norm = std::max(epoch.gradient_norm, norm);
      optimizer->step();
      const auto weight = class_weights.index_select(0, truth).sum().item<double>();
      loss_sum += value * weight, weight_sum += weight;
      correct += logits.argmax(1).eq(truth).sum().item<double>();
    }
    epoch.loss = loss_sum / weight_sum;
    epoch.accuracy = correct / static_cast<double>(samples);
    epoch.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
    epoch.images_per_s = static_cast<double>(samples) / epoch.seconds;
    return epoch;
  }
};

Weights weights_of(TemporalModule& network, const TemporalOptions& options, std::array<std::vector<float>, 2> standard) {
  const std::vector<ParameterShape> shapes = temporal_parameters(options);
  Weights weights{{shapes[0], std::move(standard[0])}, {shapes[1], std::move(standard[1])}};
  const auto named = network.named_parameters();
  for (std::size_t i = 2; i < shapes.size(); ++i) weights.push_back({shapes[i], values_of(named[shapes[i].name])});
  return weights;
}

}  // namespace

FittedTemporal fit_temporal_on_torch(std::span<const float> features, std::span<const Touch> truth,
                                     const TemporalOptions& options, const TrainingOptions& training,
                                     const ProgressCallback& progress,
                                     const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch) {
  check(options);
  check(training);
  check_input(features, truth);
  use_one_thread();
  torch::manual_seed(training.seed);
  TemporalModule network(options);
  std::array<std::vector<float>, 2> standard = standard_of(features);
  const std::array<double, touch_count> by_class = weights_of_classes(training.class_weights, truth);
  const torch::Tensor targets = torch::empty({static_cast<std::int64_t>(truth.size())}, torch::kInt64);
  std::transform(truth.begin(), truth.end(), targets.data_ptr<std::int64_t>(),
                 [](Touch touch) { return static_cast<std::int64_t>(touch); });
  const torch::Tensor class_weights = torch::empty({static_cast<std::int64_t>(touch_count)});
  std::transform(by_class.begin(), by_class.end(), class_weights.data_ptr<float>(),
                 [](double weight) { return static_cast<float>(weight); });
  Training steps_of{network,
                    inputs_of(features, standard[0], standard[1]),
                    targets,
                    class_weights,
                    training,
                    make_optimizer(training.optimizer, network.parameters(), training.learning_rate),
                    static_cast<std::int64_t>(truth.size())};
  FittedTemporal fitted;
  for (unsigned epoch = 1; epoch <= training.epochs; ++epoch) {
    fitted.history.push_back(steps_of.pass(epoch));
    const EpochResult& last = fitted.history.back();
    if (on_epoch) on_epoch(fitted.history);
    report_progress(
        progress, std::uint64_t{epoch} * truth.size(), std::uint64_t{training.epochs} * truth.size(),
        fmt::format("epoch {}/{}: loss {:.4f}, accuracy {:.1f} %", epoch, training.epochs, last.loss, 100 * last.accuracy));
  }
  fitted.weights = weights_of(network, options, std::move(standard));
  check_finite(fitted.weights, "training");
  return fitted;
}

std::vector<std::array<float, touch_count>> temporal_logits_on_torch(std::span<const float> features,
                                                                     const TemporalOptions& options, const Weights& weights) {
  check_shapes(weights, temporal_parameters(options), "a temporal convolution with other parameters than its settings");
  use_one_thread();
  const torch::NoGradGuard no_gradients;
  const auto tensor_of = [&](std::size_t i) {
    const Parameter& parameter = weights[i];
    return torch::tensor(parameter.values).reshape(parameter.shape.sizes);
  };
  torch::Tensor x = inputs_of(features, weights[0].values, weights[1].values);
  std::size_t next = 2;
  for (std::int64_t dilation = 1; dilation < steps; dilation *= 2, next += 2) {
    const std::array<std::int64_t, 1> stride{1}, padding{0}, apart{dilation};
    x = torch::relu(torch::conv1d(torch::constant_pad_nd(x, {dilation, 0}), tensor_of(next), tensor_of(next + 1),
                                  torch::IntArrayRef(stride), torch::IntArrayRef(padding), torch::IntArrayRef(apart)));
  }
  const torch::Tensor last = x.select(2, steps - 1);
  const std::vector<float> values = values_of(torch::linear(last, tensor_of(next), tensor_of(next + 1)));
  std::vector<std::array<float, touch_count>> logits(values.size() / touch_count);
  for (std::size_t i = 0; i < values.size(); ++i) logits[i / touch_count][i % touch_count] = values[i];
  return logits;
}

}  // namespace tactile::model
