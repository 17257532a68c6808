#include "tactile/model/lenet.hpp"

#include <ATen/core/ivalue.h>  // clang 14 needs it ahead of torch.h, which uses a vector of these before they are defined
#include <dlfcn.h>
#include <torch/torch.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"

namespace tactile {
namespace {

/// What one call of the network works on at once: enough to keep it busy, and always the same, so that the logits are too.
constexpr std::size_t chunk = 32;

struct Network : torch::nn::Module {
  explicit Network(const LeNetLayers& layers)
      : conv1(register_module("conv1", torch::nn::Conv2d(torch::nn::Conv2dOptions(1, 6, 5)))),
        conv2(register_module("conv2", torch::nn::Conv2d(torch::nn::Conv2dOptions(6, 16, 5)))),
        fc1(register_module("fc1", torch::nn::Linear(static_cast<std::int64_t>(layers.flat), 120))),
        fc2(register_module("fc2", torch::nn::Linear(120, 84))),
        fc3(register_module("fc3", torch::nn::Linear(84, static_cast<std::int64_t>(touch_count)))) {}

  torch::Tensor forward(torch::Tensor x) {
    x = torch::max_pool2d(torch::relu(conv1->forward(x)), 2);
    x = torch::max_pool2d(torch::relu(conv2->forward(x)), 2);
    x = torch::relu(fc1->forward(x.flatten(1)));
    return fc3->forward(torch::relu(fc2->forward(x)));
  }

  torch::nn::Conv2d conv1, conv2;
  torch::nn::Linear fc1, fc2, fc3;
};

/// OpenBLAS has threads of its own, which would work beside those asked for.
void keep_blas_to_one_thread() {
  using SetThreads = void (*)(int);
  static const bool kept = [] {
    const auto set_blas_threads = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set_blas_threads != nullptr) set_blas_threads(1);
    return true;
  }();
  static_cast<void>(kept);
}

void set_threads(unsigned threads) {
  keep_blas_to_one_thread();
  const int count = static_cast<int>(threads);
  if (at::get_num_threads() != count) at::set_num_threads(count);
}

torch::Tensor input_of(std::span<const std::uint8_t> heatmaps, SensorSize size) {
  const auto cells = static_cast<std::int64_t>(size.width) * size.height;
  const torch::Tensor input = torch::empty({static_cast<std::int64_t>(heatmaps.size()) / cells, 1, size.height, size.width});
  std::transform(heatmaps.begin(), heatmaps.end(), input.data_ptr<float>(),
                 [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
  return input;
}

std::size_t count_of(std::span<const std::uint8_t> heatmaps, SensorSize size) {
  const std::size_t cells = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  if (heatmaps.size() % cells == 0) return heatmaps.size() / cells;
  throw Error("heatmaps: " + std::to_string(heatmaps.size()) + " bytes; expected a whole number of heatmaps of " +
              std::to_string(size.width) + " x " + std::to_string(size.height) + " cells");
}

Logits logits_at(const float* row) {
  Logits logits;
  std::copy_n(row, touch_count, logits.begin());
  return logits;
}

}  // namespace

struct LeNet::State {
  LeNetLayers layers;
  std::shared_ptr<Network> network;
};

LeNet::LeNet(SensorSize input, std::uint64_t seed) : state_(std::make_unique<State>()) {
  state_->layers = lenet_layers(input);
  torch::manual_seed(seed);
  state_->network = std::make_shared<Network>(state_->layers);
}

LeNet::LeNet(SensorSize input, const Weights& weights) : LeNet(input, 0) {
  const torch::NoGradGuard no_gradients;
  const auto shapes = state_->layers.parameters();
  auto parameters = state_->network->named_parameters();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (weights.size() != shapes.size() || weights[i].shape != shapes[i] || weights[i].values.size() != shapes[i].count()) {
      throw Error("weights: not of this network; expected " + shapes[i].name + " " + nlohmann::json(shapes[i].sizes).dump());
    }
    torch::Tensor& parameter = parameters[shapes[i].name];
    std::copy(weights[i].values.begin(), weights[i].values.end(), parameter.data_ptr<float>());
  }
}

LeNet::~LeNet() = default;
LeNet::LeNet(LeNet&&) noexcept = default;
LeNet& LeNet::operator=(LeNet&&) noexcept = default;

const LeNetLayers& LeNet::layers() const { return state_->layers; }

Weights LeNet::weights() const {
  Weights weights;
  const auto parameters = state_->network->named_parameters();
  for (const ParameterShape& shape : state_->layers.parameters()) {
    const torch::Tensor values = parameters[shape.name].detach().contiguous();
    const float* first = values.data_ptr<float>();
    weights.push_back({shape, {first, first + values.numel()}});
  }
  return weights;
}

std::vector<Logits> LeNet::logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  const SensorSize size = state_->layers.input;
  const std::size_t count = count_of(heatmaps, size), cells = count == 0 ? 0 : heatmaps.size() / count;
  std::vector<Logits> logits(count);
  set_threads(1);
  parallel_for((count + chunk - 1) / chunk, threads, [&](std::size_t i) {
    const torch::NoGradGuard no_gradients;  // of each thread
    const std::size_t first = i * chunk, n = std::min(chunk, count - first);
    const torch::Tensor rows = state_->network->forward(input_of(heatmaps.subspan(first * cells, n * cells), size)).contiguous();
    for (std::size_t k = 0; k < n; ++k) logits[first + k] = logits_at(rows.data_ptr<float>() + k * touch_count);
  });
  return logits;
}

struct LeNetTrainer::State {
  State(LeNet& trained, double learning_rate, unsigned thread_count)
      : network(trained),
        adam(trained.state_->network->parameters(), torch::optim::AdamOptions(learning_rate)),
        threads(thread_count) {}

  LeNet& network;
  torch::optim::Adam adam;
  unsigned threads;
};

LeNetTrainer::LeNetTrainer(LeNet& network, double learning_rate, unsigned threads)
    : state_(std::make_unique<State>(network, learning_rate, threads)) {}

LeNetTrainer::~LeNetTrainer() = default;

BatchResult LeNetTrainer::learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth) {
  LeNet::State& network = *state_->network.state_;
  const std::size_t count = count_of(heatmaps, network.layers.input);
  if (count == 0 || count != truth.size()) {
    throw Error("training batch: " + std::to_string(count) + " heatmaps for " + std::to_string(truth.size()) +
                " touches; expected one each, and at least one");
  }
  set_threads(state_->threads);
  const torch::Tensor targets = torch::empty({static_cast<std::int64_t>(count)}, torch::kInt64);
  std::transform(truth.begin(), truth.end(), targets.data_ptr<std::int64_t>(),
                 [](Touch touch) { return static_cast<std::int64_t>(touch); });
  state_->adam.zero_grad();
  const torch::Tensor logits = network.network->forward(input_of(heatmaps, network.layers.input)).contiguous();
  torch::Tensor loss = torch::nn::functional::cross_entropy(logits, targets);
  loss.backward();
  state_->adam.step();
  BatchResult result{loss.item<double>(), 0};
  for (std::size_t i = 0; i < count; ++i) {
    result.correct += verdict_of(logits_at(logits.data_ptr<float>() + i * touch_count)) == truth[i] ? 1 : 0;
  }
  return result;
}

}  // namespace tactile
