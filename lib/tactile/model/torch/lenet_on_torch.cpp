#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/model/inference/flushed_denormals.hpp"
#include "tactile/model/torch/fused_layers.hpp"
#include "tactile/model/torch/lenet_module.hpp"
#include "tactile/model/torch/torch_part.hpp"
#include "tactile/model/torch/torch_training.hpp"
#include "tactile/model/training/blas_threads.hpp"
#include "tactile/model/training/optimizer_steps.hpp"

namespace tactile::model {
namespace {

/// Heatmaps per call of the network: enough for full speed, and constant, so that the logits do not change.
constexpr std::size_t chunk = 32;

/// Sums beyond float32 become infinite or NaN, which give no verdict.
void check_finite(std::span<const Logits> logits) {
  for (std::size_t i = 0; i < logits.size(); ++i) {
    if (std::all_of(logits[i].begin(), logits[i].end(), [](float logit) { return std::isfinite(logit); })) continue;
    throw Error(fmt::format("the logits of heatmap {} of {} are {}, {} and {}; expected finite ones, of smaller weights", i + 1,
                            logits.size(), logits[i][0], logits[i][1], logits[i][2]));
  }
}

/// @param threads     that call libtorch  @param of_libtorch  number of its own threads; its results depend on it
void set_threads(unsigned threads, unsigned of_libtorch) {
  prepare_blas(threads);
  const int count = static_cast<int>(of_libtorch);
  if (at::get_num_threads() != count) at::set_num_threads(count);
}

torch::Tensor input_of(std::span<const std::uint8_t> heatmaps, events::SensorSize size) {
  const auto cells = static_cast<std::int64_t>(size.width) * size.height;
  torch::Tensor input = torch::empty({static_cast<std::int64_t>(heatmaps.size()) / cells, 1, size.height, size.width});
  std::transform(heatmaps.begin(), heatmaps.end(), input.data_ptr<float>(),
                 [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
  return input;
}

constexpr double rate_before_first_step = 1e-3;

void copy_into(torch::Tensor& tensor, const std::vector<float>& values) {
  const torch::NoGradGuard no_gradients;
  const torch::Tensor source = torch::empty(tensor.sizes());
  std::copy(values.begin(), values.end(), source.data_ptr<float>());
  tensor.copy_(source);
}

/// The key of a parameter's state in an optimizer: its address, as a text in libtorch before 2.0.
template <class StateMap>
typename StateMap::key_type key_of(const torch::Tensor& parameter) {
  using Key = typename StateMap::key_type;
  if constexpr (std::is_same_v<Key, std::string>) {
    std::ostringstream address;
    address << parameter.unsafeGetTensorImpl();
    return address.str();
  } else {
    return static_cast<Key>(parameter.unsafeGetTensorImpl());
  }
}

/// A parameter's moments, in the order of `moment_shapes`.
template <class AdamState>
std::vector<torch::Tensor> adam_moments(const AdamState& state) {
  return {state.exp_avg(), state.exp_avg_sq()};
}

Logits logits_at(const float* row) {
  Logits logits;
  std::copy_n(row, touch_count, logits.begin());
  return logits;
}

/// Its module is shared with the trainer.
class LeNetWithModule : public LeNetOnTorch {
 public:
  LeNetWithModule(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options) : layers_(lenet_layers(input)) {
    torch::manual_seed(seed);
    module_ = std::make_shared<LeNetModule>(layers_, options);
  }

  LeNetWithModule(events::SensorSize input, const Weights& weights, const LeNetOptions& options)
      : LeNetWithModule(input, 0, options) {
    const torch::NoGradGuard no_gradients;
    check_shapes(weights, layers_.parameters(), "weights: not of this network");
    auto parameters = module_->named_parameters();
    for (const Parameter& weight : weights) copy_into(parameters[weight.shape.name], weight.values);
  }

  const std::shared_ptr<LeNetModule>& module() const { return module_; }

  const LeNetLayers& layers() const override { return layers_; }

  Weights weights() const override {
    Weights weights;
    const auto parameters = module_->named_parameters();
    for (const ParameterShape& shape : layers_.parameters()) weights.push_back({shape, values_of(parameters[shape.name])});
    return weights;
  }

  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const override {
    const events::SensorSize size = layers_.input;
    const std::size_t count = heatmap_count(heatmaps, size), cells = count == 0 ? 0 : heatmaps.size() / count;
    std::vector<Logits> logits(count);
    set_threads(threads, 1);
    parallel_for((count + chunk - 1) / chunk, threads, [&](std::size_t i) {
      const torch::NoGradGuard no_gradients;  // of each thread
      const FlushedDenormals flushed;
      const std::size_t first = i * chunk, n = std::min(chunk, count - first);
      const torch::Tensor rows = module_->forward(input_of(heatmaps.subspan(first * cells, n * cells), size)).contiguous();
      for (std::size_t k = 0; k < n; ++k) logits[first + k] = logits_at(rows.data_ptr<float>() + k * touch_count);
    });
    check_finite(logits);
    return logits;
  }

 private:
  LeNetLayers layers_;
  std::shared_ptr<LeNetModule> module_;
};

class TrainerWithModule : public TrainerOnTorch {
 public:
  TrainerWithModule(LeNetWithModule& of, OptimizerKind optimizer_kind, const std::array<double, touch_count>& class_weights,
                    unsigned thread_count, const TrainerOptions& options)
      : network_(of),
        trained_(of.module()),
        kind_(optimizer_kind),
        fast_(options.engine == EngineKind::fast && !options.float64),
        weights_(class_weights),
        threads_(thread_count) {
    if (options.float64) {
      trained_ = std::make_shared<LeNetModule>(of.layers(), of.module()->options);
      const torch::NoGradGuard no_gradients;
      const auto from = of.module()->parameters(), to = trained_->parameters();
      for (std::size_t i = 0; i < to.size(); ++i) torch::Tensor(to[i]).copy_(from[i]);
      trained_->to(torch::kFloat64);
    }
    parameters_ = trained_->parameters();
    if (fast_ && trained_->options.is_fast()) batch_ = std::make_unique<FusedBatch>(of.layers(), threads_);
    if (fast_)
      forget();
    else
      optimizer_ = make_optimizer(kind_, parameters_, rate_before_first_step);
    torch::Tensor tensor = torch::empty({static_cast<std::int64_t>(touch_count)}, parameters_[0].options().requires_grad(false));
    for (std::size_t i = 0; i < touch_count; ++i) tensor[static_cast<std::int64_t>(i)] = weights_[i];
    const bool all_alike = std::all_of(weights_.begin(), weights_.end(), [](double weight) { return weight == 1.0; });
    if (!all_alike) loss_options_.weight(tensor);
  }

  BatchResult learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate) override {
    const std::size_t count = heatmap_count(heatmaps, network_.layers().input);
    if (count == 0 || count != truth.size()) {
      throw Error("training batch: " + std::to_string(count) + " heatmaps for " + std::to_string(truth.size()) +
                  " touches; expected one each, and at least one");
    }
    set_threads(threads_, batch_ ? 1 : threads_);
    const torch::Tensor targets = torch::empty({static_cast<std::int64_t>(count)}, torch::kInt64);
    std::transform(truth.begin(), truth.end(), targets.data_ptr<std::int64_t>(),
                   [](Touch touch) { return static_cast<std::int64_t>(touch); });
    for (torch::Tensor& parameter : parameters_) parameter.mutable_grad().reset();  // otherwise gradients are added to zeros
    const torch::Tensor logits = logits_of(heatmaps);
    torch::Tensor loss = torch::nn::functional::cross_entropy(logits, targets, loss_options_);
    loss.backward();
    BatchResult result{.loss = loss.item<double>()};
    const std::vector<float> values = values_of(logits);
    for (std::size_t i = 0; i < count; ++i) {
      result.correct += verdict_of(logits_at(values.data() + i * touch_count)) == truth[i] ? 1 : 0;
      result.weight += weights_[static_cast<std::size_t>(truth[i])];
    }
    result.moved = measure_gradient(result);
    if (result.moved) move(learning_rate);
    return result;
  }

  OptimizerState state() const override {
    OptimizerState state{step_, {}};
    for (ParameterShape& shape : moment_shapes(kind_, network_.layers().parameters())) {
      const std::size_t i = state.moments.size();
      const torch::Tensor moment = moments_of(i % parameters_.size()).at(i / parameters_.size());
      state.moments.push_back({std::move(shape), values_of(moment)});
    }
    return state;
  }

  void restore(const OptimizerState& state) override {
    const auto shapes = network_.layers().parameters();
    check_shapes(state.moments, moment_shapes(kind_, shapes), "optimizer's state: not of this network and optimizer");
    step_ = state.step;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      std::vector<torch::Tensor> kept;
      for (std::size_t moment = i; moment < state.moments.size(); moment += shapes.size()) {
        kept.push_back(torch::empty_like(parameters_[i], torch::TensorOptions().requires_grad(false)));
        copy_into(kept.back(), state.moments[moment].values);
      }
      set_moments(i, kept);
    }
  }

 private:
  /// The initial moments of the fast engine.
  void forget() {
    moments_.clear();
    for (const torch::Tensor& parameter : parameters_) {
      moments_.emplace_back();
      for (std::size_t i = 0; i < (kind_ == OptimizerKind::sgd ? 1 : 2); ++i)
        moments_.back().push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
    }
  }

  torch::Tensor logits_of(std::span<const std::uint8_t> heatmaps) {
    if (!batch_) return trained_->forward(input_of(heatmaps, network_.layers().input).to(parameters_[0].scalar_type()));
    batch_->set_heatmaps(heatmaps);
    const torch::Tensor flat = FusedLayers::apply(trained_->conv1->weight, trained_->conv1->bias, trained_->conv2->weight,
                                                  trained_->conv2->bias, batch_.get());
    return trained_->connected_after_first(
        FusedLinear::apply(flat, trained_->fc1->weight, trained_->fc1->bias, static_cast<std::int64_t>(threads_)));
  }

  /// @return  whether the gradient is finite and not too large
  bool measure_gradient(BatchResult& result) const {
    double squares = 0;
    for (const torch::Tensor& parameter : parameters_) {
      if (fast_) {
        squares += sum_of_squares(values_in(parameter.grad()), threads_);
      } else {
        const auto norm = parameter.grad().norm().item<double>();
        squares += norm * norm;
      }
    }
    result.gradient_norm = std::sqrt(squares);
    return std::isfinite(result.loss) && result.gradient_norm <= largest_gradient_norm;
  }

  static std::span<float> values_in(const torch::Tensor& tensor) {
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
  }

  void move(double learning_rate) {
    ++step_;
    if (!fast_) {
      for (auto& group : optimizer_->param_groups()) group.options().set_lr(learning_rate);
      optimizer_->step();
      if (trained_ == network_.module()) return;
      const torch::NoGradGuard no_gradients;
      const auto rounded = network_.module()->parameters();
      for (std::size_t i = 0; i < parameters_.size(); ++i) torch::Tensor(rounded[i]).copy_(parameters_[i]);
      return;
    }
    constexpr std::size_t piece = 16384;  // values per piece of work
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      const auto count = static_cast<std::size_t>(parameters_[i].numel()), pieces = (count + piece - 1) / piece;
      parallel_for(pieces, threads_, [&](std::size_t k) {
        const auto part = [&](const torch::Tensor& tensor) {
          return values_in(tensor).subspan(k * piece, std::min(piece, count - k * piece));
        };
        take_step({kind_, learning_rate, step_}, {part(parameters_[i]), part(parameters_[i].grad()), part(moments_[i][0]),
                                                  moments_[i].size() > 1 ? part(moments_[i][1]) : std::span<float>()});
      });
    }
  }

  std::vector<torch::Tensor> moments_of(std::size_t i) const {
    if (fast_) return moments_[i];
    const auto& states = optimizer_->state();
    const auto found = states.find(key_of<std::decay_t<decltype(states)>>(parameters_[i]));
    if (found == states.end()) return {};
    if (kind_ == OptimizerKind::adam) return adam_moments(static_cast<const torch::optim::AdamParamState&>(*found->second));
    if (kind_ == OptimizerKind::adamw) return adam_moments(static_cast<const torch::optim::AdamWParamState&>(*found->second));
    return {static_cast<const torch::optim::SGDParamState&>(*found->second).momentum_buffer()};
  }

  void set_moments(std::size_t i, const std::vector<torch::Tensor>& kept) {
    if (fast_) {
      moments_[i] = kept;
      return;
    }
    auto& states = optimizer_->state();
    auto& place = states[key_of<std::decay_t<decltype(states)>>(parameters_[i])];
    const auto as_adam = [&](auto state) {
      state->step(step_);
      state->exp_avg(kept[0]);
      state->exp_avg_sq(kept[1]);
      place = std::move(state);
    };
    if (kind_ == OptimizerKind::adam) return as_adam(std::make_unique<torch::optim::AdamParamState>());
    if (kind_ == OptimizerKind::adamw) return as_adam(std::make_unique<torch::optim::AdamWParamState>());
    auto state = std::make_unique<torch::optim::SGDParamState>();
    state->momentum_buffer(kept[0]);
    place = std::move(state);
  }

  LeNetWithModule& network_;
  std::shared_ptr<LeNetModule> trained_;  ///< the network's module, or a copy in float64
  OptimizerKind kind_;
  bool fast_;
  std::vector<torch::Tensor> parameters_;               ///< of `trained_`, in the order of the layers
  std::unique_ptr<FusedBatch> batch_;                   ///< null with libtorch's layers
  std::unique_ptr<torch::optim::Optimizer> optimizer_;  ///< null if our steps are used, with
  std::vector<std::vector<torch::Tensor>> moments_;     ///< these of each parameter
  std::array<double, touch_count> weights_;
  torch::nn::functional::CrossEntropyFuncOptions loss_options_;
  std::int64_t step_ = 0;
  unsigned threads_;
};

std::unique_ptr<LeNetOnTorch> new_lenet(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options) {
  return std::make_unique<LeNetWithModule>(input, seed, options);
}

std::unique_ptr<LeNetOnTorch> lenet_of(events::SensorSize input, const Weights& weights, const LeNetOptions& options) {
  return std::make_unique<LeNetWithModule>(input, weights, options);
}

std::unique_ptr<TrainerOnTorch> new_trainer(LeNetOnTorch& network, OptimizerKind optimizer,
                                            const std::array<double, touch_count>& class_weights, unsigned threads,
                                            const TrainerOptions& options) {
  return std::make_unique<TrainerWithModule>(static_cast<LeNetWithModule&>(network), optimizer, class_weights, threads, options);
}

}  // namespace
}  // namespace tactile::model

extern "C" const tactile::model::TorchPart tactile_torch_part{tactile::model::new_lenet,
                                                              tactile::model::lenet_of,
                                                              tactile::model::new_trainer,
                                                              tactile::model::fit_stream_on_torch,
                                                              tactile::model::stream_logits_on_torch,
                                                              tactile::model::own_network_on_torch};
