#include "tactile/model/training/lenet.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/model/training/blas_threads.hpp"
#include "tactile/model/training/optimizer_steps.hpp"
#include "tactile/model/training/torch_fused.hpp"
#include "tactile/model/training/torch_network.hpp"

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

void set_threads(unsigned threads) {
  prepare_blas(threads);
  const int count = static_cast<int>(threads);
  if (at::get_num_threads() != count) at::set_num_threads(count);
}

torch::Tensor input_of(std::span<const std::uint8_t> heatmaps, events::SensorSize size) {
  const auto cells = static_cast<std::int64_t>(size.width) * size.height;
  const torch::Tensor input = torch::empty({static_cast<std::int64_t>(heatmaps.size()) / cells, 1, size.height, size.width});
  std::transform(heatmaps.begin(), heatmaps.end(), input.data_ptr<float>(),
                 [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
  return input;
}

std::vector<float> values_of(const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.detach().to(torch::kFloat32).contiguous();
  const float* first = values.data_ptr<float>();
  return {first, first + values.numel()};
}

void copy_into(torch::Tensor& tensor, const std::vector<float>& values) {
  const torch::NoGradGuard no_gradients;
  const torch::Tensor source = torch::empty(tensor.sizes());
  std::copy(values.begin(), values.end(), source.data_ptr<float>());
  tensor.copy_(source);
}

/// The moments of an optimizer, with the names in its papers and libtorch.
std::vector<std::string> moment_names(OptimizerKind optimizer) {
  if (optimizer == OptimizerKind::sgd) return {"momentum_buffer"};
  return {"exp_avg", "exp_avg_sq"};
}

ParameterShape moment_shape(const std::string& moment, const ParameterShape& parameter) {
  return {"optimizer." + moment + "." + parameter.name, parameter.sizes};
}

std::unique_ptr<torch::optim::Optimizer> make_optimizer(OptimizerKind kind, const std::vector<torch::Tensor>& parameters) {
  constexpr double set_with_each_step = 1e-3;
  if (kind == OptimizerKind::adamw)
    return std::make_unique<torch::optim::AdamW>(parameters, torch::optim::AdamWOptions(set_with_each_step).weight_decay(0.01));
  if (kind == OptimizerKind::sgd)
    return std::make_unique<torch::optim::SGD>(parameters, torch::optim::SGDOptions(set_with_each_step).momentum(0.9));
  return std::make_unique<torch::optim::Adam>(parameters, torch::optim::AdamOptions(set_with_each_step));
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

/// A parameter's moments, in the order of `moment_names`.
template <class AdamState>
std::vector<torch::Tensor> adam_moments(const AdamState& state) {
  return {state.exp_avg(), state.exp_avg_sq()};
}

Logits logits_at(const float* row) {
  Logits logits;
  std::copy_n(row, touch_count, logits.begin());
  return logits;
}

}  // namespace

struct LeNet::State {
  LeNetLayers layers;
  std::shared_ptr<LeNetModule> network;
};

LeNet::LeNet(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options) : state_(std::make_unique<State>()) {
  state_->layers = lenet_layers(input, options);
  torch::manual_seed(seed);
  state_->network = std::make_shared<LeNetModule>(state_->layers, options);
}

LeNet::LeNet(events::SensorSize input, const Weights& weights, const LeNetOptions& options) : LeNet(input, 0, options) {
  const torch::NoGradGuard no_gradients;
  const auto shapes = state_->layers.parameters();
  check_shapes(weights, shapes, "weights: not of this network");
  auto parameters = state_->network->named_parameters();
  for (const Parameter& weight : weights) copy_into(parameters[weight.shape.name], weight.values);
}

LeNet::~LeNet() = default;
LeNet::LeNet(LeNet&&) noexcept = default;
LeNet& LeNet::operator=(LeNet&&) noexcept = default;

const LeNetLayers& LeNet::layers() const { return state_->layers; }

Weights LeNet::weights() const {
  Weights weights;
  const auto parameters = state_->network->named_parameters();
  for (const ParameterShape& shape : state_->layers.parameters()) weights.push_back({shape, values_of(parameters[shape.name])});
  return weights;
}

std::vector<Logits> LeNet::logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  const events::SensorSize size = state_->layers.input;
  const std::size_t count = heatmap_count(heatmaps, size), cells = count == 0 ? 0 : heatmaps.size() / count;
  std::vector<Logits> logits(count);
  set_threads(1);
  parallel_for((count + chunk - 1) / chunk, threads, [&](std::size_t i) {
    const torch::NoGradGuard no_gradients;  // of each thread
    const std::size_t first = i * chunk, n = std::min(chunk, count - first);
    const torch::Tensor rows = state_->network->forward(input_of(heatmaps.subspan(first * cells, n * cells), size)).contiguous();
    for (std::size_t k = 0; k < n; ++k) logits[first + k] = logits_at(rows.data_ptr<float>() + k * touch_count);
  });
  check_finite(logits);
  return logits;
}

std::vector<ParameterShape> moment_shapes(OptimizerKind optimizer, const std::vector<ParameterShape>& parameters) {
  std::vector<ParameterShape> shapes;
  for (const std::string& moment : moment_names(optimizer)) {
    for (const ParameterShape& parameter : parameters) shapes.push_back(moment_shape(moment, parameter));
  }
  return shapes;
}

struct LeNetTrainer::State {
  State(LeNet& of, OptimizerKind optimizer_kind, const std::array<double, touch_count>& class_weights, unsigned thread_count,
        const TrainerOptions& options)
      : network(of),
        trained(of.state_->network),
        kind(optimizer_kind),
        fast(options.engine == EngineKind::fast && !options.float64),
        weights(class_weights),
        threads(thread_count) {
    if (options.float64) {
      trained = std::make_shared<LeNetModule>(of.layers(), of.state_->network->options);
      const torch::NoGradGuard no_gradients;
      const auto from = of.state_->network->parameters(), to = trained->parameters();
      for (std::size_t i = 0; i < to.size(); ++i) torch::Tensor(to[i]).copy_(from[i]);
      trained->to(torch::kFloat64);
    }
    parameters = trained->parameters();
    if (fast && trained->options.is_fast()) batch = std::make_unique<FusedBatch>(of.layers(), threads);
    if (fast)
      forget();
    else
      optimizer = make_optimizer(kind, parameters);
    torch::Tensor tensor = torch::empty({static_cast<std::int64_t>(touch_count)}, parameters[0].options().requires_grad(false));
    for (std::size_t i = 0; i < touch_count; ++i) tensor[static_cast<std::int64_t>(i)] = weights[i];
    const bool all_alike = std::all_of(weights.begin(), weights.end(), [](double weight) { return weight == 1.0; });
    if (!all_alike) loss_options.weight(tensor);
  }

  /// The initial moments of the fast engine.
  void forget() {
    moments.clear();
    for (const torch::Tensor& parameter : parameters) {
      moments.emplace_back();
      for (std::size_t i = 0; i < moment_names(kind).size(); ++i)
        moments.back().push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
    }
  }

  torch::Tensor logits_of(std::span<const std::uint8_t> heatmaps) {
    if (!batch) return trained->forward(input_of(heatmaps, network.layers().input).to(parameters[0].scalar_type()));
    batch->set_heatmaps(heatmaps);
    const torch::Tensor flat = FusedLayers::apply(trained->conv1->weight, trained->conv1->bias, trained->conv2->weight,
                                                  trained->conv2->bias, batch.get());
    return connected(trained->options.last_pool == 2 ? flat : trained->flattened(flat.view(second_sizes())));
  }

  /// The second pooled layer of a batch: [n, channels, height, width].
  std::vector<std::int64_t> second_sizes() const {
    const LeNetLayers& layers = network.layers();
    return {-1, static_cast<std::int64_t>(layers.second_channels), layers.second_pooled.height, layers.second_pooled.width};
  }

  torch::Tensor connected(const torch::Tensor& flat) const {
    if (threads == 1) return trained->connected(flat);
    return trained->connected_after_first(
        SharedLinear::apply(flat, trained->fc1->weight, trained->fc1->bias, static_cast<std::int64_t>(threads)));
  }

  /// @return  whether the gradient is finite and not too large
  bool measure_gradient(BatchResult& result) const {
    double squares = 0;
    for (const torch::Tensor& parameter : parameters) {
      if (fast) {
        squares += sum_of_squares(values_in(parameter.grad()));
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
    ++step;
    if (!fast) {
      for (auto& group : optimizer->param_groups()) group.options().set_lr(learning_rate);
      optimizer->step();
      if (trained == network.state_->network) return;
      const torch::NoGradGuard no_gradients;
      const auto rounded = network.state_->network->parameters();
      for (std::size_t i = 0; i < parameters.size(); ++i) torch::Tensor(rounded[i]).copy_(parameters[i]);
      return;
    }
    constexpr std::size_t piece = 65536;  // values per piece of work
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const auto count = static_cast<std::size_t>(parameters[i].numel()), pieces = (count + piece - 1) / piece;
      parallel_for(pieces, threads, [&](std::size_t k) {
        const auto part = [&](const torch::Tensor& tensor) {
          return values_in(tensor).subspan(k * piece, std::min(piece, count - k * piece));
        };
        take_step({kind, learning_rate, step}, {part(parameters[i]), part(parameters[i].grad()), part(moments[i][0]),
                                                moments[i].size() > 1 ? part(moments[i][1]) : std::span<float>()});
      });
    }
  }

  std::vector<torch::Tensor> moments_of(std::size_t i) const {
    if (fast) return moments[i];
    const auto& states = optimizer->state();
    const auto found = states.find(key_of<std::decay_t<decltype(states)>>(parameters[i]));
    if (found == states.end()) return {};
    if (kind == OptimizerKind::adam) return adam_moments(static_cast<const torch::optim::AdamParamState&>(*found->second));
    if (kind == OptimizerKind::adamw) return adam_moments(static_cast<const torch::optim::AdamWParamState&>(*found->second));
    return {static_cast<const torch::optim::SGDParamState&>(*found->second).momentum_buffer()};
  }

  void set_moments(std::size_t i, const std::vector<torch::Tensor>& kept) {
    if (fast) {
      moments[i] = kept;
      return;
    }
    auto& states = optimizer->state();
    auto& place = states[key_of<std::decay_t<decltype(states)>>(parameters[i])];
    const auto as_adam = [&](auto state) {
      state->step(step);
      state->exp_avg(kept[0]);
      state->exp_avg_sq(kept[1]);
      place = std::move(state);
    };
    if (kind == OptimizerKind::adam) return as_adam(std::make_unique<torch::optim::AdamParamState>());
    if (kind == OptimizerKind::adamw) return as_adam(std::make_unique<torch::optim::AdamWParamState>());
    auto state = std::make_unique<torch::optim::SGDParamState>();
    state->momentum_buffer(kept[0]);
    place = std::move(state);
  }

  LeNet& network;
  std::shared_ptr<LeNetModule> trained;  ///< the network's module, or a copy in float64
  OptimizerKind kind;
  bool fast;
  std::vector<torch::Tensor> parameters;               ///< of `trained`, in the order of the layers
  std::unique_ptr<FusedBatch> batch;                   ///< null with libtorch's layers
  std::unique_ptr<torch::optim::Optimizer> optimizer;  ///< null if our steps are used, with
  std::vector<std::vector<torch::Tensor>> moments;     ///< these of each parameter
  std::array<double, touch_count> weights;
  torch::nn::functional::CrossEntropyFuncOptions loss_options;
  std::int64_t step = 0;
  unsigned threads;
};

LeNetTrainer::LeNetTrainer(LeNet& network, OptimizerKind optimizer, const std::array<double, touch_count>& class_weights,
                           unsigned threads, const TrainerOptions& options)
    : state_(std::make_unique<State>(network, optimizer, class_weights, threads, options)) {}

LeNetTrainer::~LeNetTrainer() = default;

BatchResult LeNetTrainer::learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate) {
  const std::size_t count = heatmap_count(heatmaps, state_->network.layers().input);
  if (count == 0 || count != truth.size()) {
    throw Error("training batch: " + std::to_string(count) + " heatmaps for " + std::to_string(truth.size()) +
                " touches; expected one each, and at least one");
  }
  set_threads(state_->threads);
  const torch::Tensor targets = torch::empty({static_cast<std::int64_t>(count)}, torch::kInt64);
  std::transform(truth.begin(), truth.end(), targets.data_ptr<std::int64_t>(),
                 [](Touch touch) { return static_cast<std::int64_t>(touch); });
  for (torch::Tensor& parameter : state_->parameters) parameter.mutable_grad().reset();  // otherwise gradients are added to zeros
  const torch::Tensor logits = state_->logits_of(heatmaps);
  torch::Tensor loss = torch::nn::functional::cross_entropy(logits, targets, state_->loss_options);
  loss.backward();
  BatchResult result{.loss = loss.item<double>()};
  const std::vector<float> values = values_of(logits);
  for (std::size_t i = 0; i < count; ++i) {
    result.correct += verdict_of(logits_at(values.data() + i * touch_count)) == truth[i] ? 1 : 0;
    result.weight += state_->weights[static_cast<std::size_t>(truth[i])];
  }
  result.moved = state_->measure_gradient(result);
  if (result.moved) state_->move(learning_rate);
  return result;
}

OptimizerState LeNetTrainer::state() const {
  OptimizerState state{state_->step, {}};
  const auto names = moment_names(state_->kind);
  const auto shapes = state_->network.layers().parameters();
  for (std::size_t moment = 0; moment < names.size(); ++moment) {
    for (std::size_t i = 0; i < shapes.size(); ++i)
      state.moments.push_back({moment_shape(names[moment], shapes[i]), values_of(state_->moments_of(i).at(moment))});
  }
  return state;
}

void LeNetTrainer::restore(const OptimizerState& state) {
  const auto shapes = state_->network.layers().parameters();
  check_shapes(state.moments, moment_shapes(state_->kind, shapes), "optimizer's state: not of this network and optimizer");
  state_->step = state.step;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    std::vector<torch::Tensor> moments;
    for (std::size_t moment = i; moment < state.moments.size(); moment += shapes.size()) {
      moments.push_back(torch::empty_like(state_->parameters[i], torch::TensorOptions().requires_grad(false)));
      copy_into(moments.back(), state.moments[moment].values);
    }
    state_->set_moments(i, moments);
  }
}

}  // namespace tactile::model
