#include "tactile/model/training/lenet.hpp"

#include <ATen/core/ivalue.h>  // clang 14 needs it ahead of torch.h, which uses a vector of these before they are defined
#include <dlfcn.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <torch/torch.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <sstream>
#include <type_traits>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/model/training/fused_convolutions.hpp"
#include "tactile/model/training/optimizer_steps.hpp"

namespace tactile {
namespace {

/// What one call of the network works on at once: enough to keep it busy, and always the same, so that the logits are too.
constexpr std::size_t chunk = 32;

/// Whether a pool that holds `best` takes `value` in its place: NaN stays, so that it is seen at the network's end.
bool takes(float best, float value) {
  return static_cast<bool>(static_cast<int>(value > best) | static_cast<int>(value != value));
}

/// Sums that leave float32 become infinite, and NaN where infinities meet: no verdict lies in these.
void check_finite(std::span<const Logits> logits) {
  for (std::size_t i = 0; i < logits.size(); ++i) {
    if (std::all_of(logits[i].begin(), logits[i].end(), [](float logit) { return std::isfinite(logit); })) continue;
    throw Error(fmt::format("the logits of heatmap {} of {} are {}, {} and {}; expected finite ones, of smaller weights", i + 1,
                            logits.size(), logits[i][0], logits[i][1], logits[i][2]));
  }
}

/// The largest value of each 2 x 2 block and its gradient, as torch::max_pool2d(x, 2) gives both, to the last bit: that one looks
/// at a value at a time and was a quarter of all work.
class LargestOfBlocks : public torch::autograd::Function<LargestOfBlocks> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input) {
    const torch::Tensor x = input.contiguous();
    torch::Tensor largest = torch::empty({x.size(0), x.size(1), x.size(2) / 2, x.size(3) / 2});
    const Blocks blocks(x);
    for (std::int64_t row = 0; row < blocks.rows; ++row) {
      const float* upper = x.data_ptr<float>() + blocks.offset(row);
      const float* lower = upper + blocks.stride;
      float* out = largest.data_ptr<float>() + row * blocks.width;
      for (std::int64_t i = 0; i < blocks.width; ++i) {
        float best = upper[2 * i];
        best = takes(best, upper[2 * i + 1]) ? upper[2 * i + 1] : best;
        best = takes(best, lower[2 * i]) ? lower[2 * i] : best;
        out[i] = takes(best, lower[2 * i + 1]) ? lower[2 * i + 1] : best;
      }
    }
    context->save_for_backward({x});
    return largest;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const torch::Tensor x = context->get_saved_variables()[0], gradient = gradients[0].contiguous();
    const Blocks blocks(x);
    const bool leaves_some = x.size(2) % 2 != 0 || x.size(3) % 2 != 0;  // a row or column that no block holds
    const torch::Tensor result = leaves_some ? torch::zeros_like(x) : torch::empty_like(x);
    for (std::int64_t row = 0; row < blocks.rows; ++row) {
      const float* upper = x.data_ptr<float>() + blocks.offset(row);
      const float* lower = upper + blocks.stride;
      const float* in = gradient.data_ptr<float>() + row * blocks.width;
      float* upper_out = result.data_ptr<float>() + blocks.offset(row);
      float* lower_out = upper_out + blocks.stride;
      for (std::int64_t i = 0; i < blocks.width; ++i) {
        const float a = upper[2 * i], b = upper[2 * i + 1], c = lower[2 * i], d = lower[2 * i + 1], slope = in[i];
        const bool takes_b = takes(a, b);
        const float of_two = takes_b ? b : a;
        const bool takes_c = takes(of_two, c);
        const bool takes_d = takes(takes_c ? c : of_two, d);
        const float above = takes_d || takes_c ? 0.0F : slope, below = takes_d ? 0.0F : slope;
        upper_out[2 * i] = takes_b ? 0.0F : above;
        upper_out[2 * i + 1] = takes_b ? above : 0.0F;
        lower_out[2 * i] = takes_c ? below : 0.0F;
        lower_out[2 * i + 1] = takes_d ? slope : 0.0F;
      }
    }
    return {result};
  }

 private:
  /// Rows of blocks, over all pictures and channels.
  struct Blocks {
    explicit Blocks(const torch::Tensor& x)
        : height(x.size(2) / 2), width(x.size(3) / 2), stride(x.size(3)), channel(x.size(2) * x.size(3)) {
      rows = x.size(0) * x.size(1) * height;
    }
    std::int64_t offset(std::int64_t row) const { return row / height * channel + row % height * 2 * stride; }

    std::int64_t height, width, stride, channel, rows = 0;
  };
};

struct Network : torch::nn::Module {
  Network(const LeNetLayers& layers, const LeNetOptions& chosen)
      : options(chosen),
        conv1(register_module("conv1", torch::nn::Conv2d(torch::nn::Conv2dOptions(1, 6, 5)))),
        conv2(register_module("conv2", torch::nn::Conv2d(torch::nn::Conv2dOptions(6, 16, 5)))),
        fc1(register_module("fc1", torch::nn::Linear(static_cast<std::int64_t>(layers.flat), 120))),
        fc2(register_module("fc2", torch::nn::Linear(120, 84))),
        fc3(register_module("fc3", torch::nn::Linear(84, static_cast<std::int64_t>(touch_count)))) {}

  torch::Tensor activated(const torch::Tensor& x) const {
    return options.activation == Activation::relu   ? torch::relu(x)
           : options.activation == Activation::tanh ? torch::tanh(x)
                                                    : torch::sigmoid(x);
  }

  /// An activation never falls, so the largest of activated values is the activated largest: a quarter of them is enough.
  torch::Tensor activated_and_pooled(const torch::Tensor& x) const {
    if (options.pooling == Pooling::average) return torch::avg_pool2d(activated(x), 2);
    return activated(x.scalar_type() == torch::kFloat32 ? LargestOfBlocks::apply(x) : torch::max_pool2d(x, 2));
  }

  torch::Tensor convolved(const torch::Tensor& x) {
    return activated_and_pooled(conv2->forward(activated_and_pooled(conv1->forward(x)))).flatten(1);
  }

  torch::Tensor connected(const torch::Tensor& x) { return connected_behind(fc1->forward(x)); }

  /// Behind the first fully connected layer, which has all but all of the weights.
  torch::Tensor connected_behind(const torch::Tensor& x) { return fc3->forward(activated(fc2->forward(activated(x)))); }

  torch::Tensor forward(const torch::Tensor& x) { return connected(convolved(x)); }

  LeNetOptions options;

  torch::nn::Conv2d conv1, conv2;
  torch::nn::Linear fc1, fc2, fc3;
};

/// A batch on its way through the fused layers and back, and the memory for it, which later batches use again.
class FusedBatch {
 public:
  FusedBatch(const LeNetLayers& layers, unsigned threads)
      : layers_(layers),
        cells_(static_cast<std::size_t>(layers.input.width) * static_cast<std::size_t>(layers.input.height)),
        passes_(layers),
        workspaces_(threads, passes_.make_workspace()) {}

  unsigned threads() const { return static_cast<unsigned>(workspaces_.size()); }

  /// What the next pass is of; must outlive it.
  void set_heatmaps(std::span<const std::uint8_t> heatmaps) { heatmaps_ = heatmaps; }

  torch::Tensor forward(const ConvolutionValues<const float>& weights) {
    passes_.set(weights);
    while (kept_.size() < count()) kept_.push_back(passes_.make_kept());
    torch::Tensor flat = torch::empty({static_cast<std::int64_t>(count()), static_cast<std::int64_t>(layers_.flat)});
    const std::span<float> values(flat.data_ptr<float>(), count() * layers_.flat);
    for_slices([&](std::size_t, std::size_t i, FusedConvolutions::Workspace& workspace) {
      passes_.forward(heatmap(i), values.subspan(i * layers_.flat, layers_.flat), kept_[i], workspace);
    });
    return flat;
  }

  void backward(const torch::Tensor& gradient, const ConvolutionValues<float>& into) {
    const std::span<const float> values(gradient.data_ptr<float>(), count() * layers_.flat);
    sums_.resize(std::max(sums_.size(), slices()));
    for (auto& sum : sums_) sum.clear();
    for_slices([&](std::size_t slice, std::size_t i, FusedConvolutions::Workspace& workspace) {
      passes_.backward(heatmap(i), kept_[i], values.subspan(i * layers_.flat, layers_.flat), sums_[slice], workspace);
    });
    for (std::size_t slice = 1; slice < slices(); ++slice) sums_[0].add(sums_[slice]);
    sums_[0].write(into);
  }

 private:
  static constexpr std::size_t slice_size = 4;  ///< heatmaps whose gradients are summed first, whatever the threads

  std::size_t count() const { return heatmaps_.size() / cells_; }
  std::size_t slices() const { return (count() + slice_size - 1) / slice_size; }
  std::span<const std::uint8_t> heatmap(std::size_t i) const { return heatmaps_.subspan(i * cells_, cells_); }

  /// Each slice on whichever thread is free: what it comes to does not depend on that.
  template <class Work>
  void for_slices(const Work& work) {
    std::atomic<std::size_t> next{0};
    parallel_for(workspaces_.size(), threads(), [&](std::size_t thread) {
      for (std::size_t slice = next++; slice < slices(); slice = next++) {
        for (std::size_t i = slice * slice_size; i < std::min(count(), (slice + 1) * slice_size); ++i)
          work(slice, i, workspaces_[thread]);
      }
    });
  }

  LeNetLayers layers_;
  std::size_t cells_;
  FusedConvolutions passes_;
  std::span<const std::uint8_t> heatmaps_;
  std::vector<FusedConvolutions::Kept> kept_;             ///< of each heatmap
  std::vector<FusedConvolutions::Workspace> workspaces_;  ///< of each thread
  std::vector<FusedConvolutions::Gradients> sums_;        ///< of each slice
};

/// The convolution layers of a batch as libtorch sees them.
class FusedLayers : public torch::autograd::Function<FusedLayers> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& first_weight,
                               const torch::Tensor& first_bias, const torch::Tensor& second_weight,
                               const torch::Tensor& second_bias, FusedBatch* batch) {
    context->saved_data["batch"] = static_cast<std::int64_t>(reinterpret_cast<std::intptr_t>(batch));
    return batch->forward({first_weight.data_ptr<float>(), first_bias.data_ptr<float>(), second_weight.data_ptr<float>(),
                           second_bias.data_ptr<float>()});
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    auto* batch = reinterpret_cast<FusedBatch*>(static_cast<std::intptr_t>(context->saved_data["batch"].toInt()));
    const torch::Tensor first_weight = torch::empty({6, 1, 5, 5}), first_bias = torch::empty({6});
    const torch::Tensor second_weight = torch::empty({16, 6, 5, 5}), second_bias = torch::empty({16});
    batch->backward(gradients[0].contiguous(), {first_weight.data_ptr<float>(), first_bias.data_ptr<float>(),
                                                second_weight.data_ptr<float>(), second_bias.data_ptr<float>()});
    return {first_weight, first_bias, second_weight, second_bias, torch::Tensor()};
  }
};

/// A fully connected layer whose units are shared out among threads, as libtorch's layer gives it. OpenBLAS, which has one
/// thread, is called by each.
class SharedLinear : public torch::autograd::Function<SharedLinear> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input, const torch::Tensor& weight,
                               const torch::Tensor& bias, std::int64_t threads) {
    context->save_for_backward({input, weight});
    context->saved_data["threads"] = threads;
    const torch::Tensor output = torch::empty({input.size(0), weight.size(0)});
    share(weight.size(0), threads, [&](std::int64_t first, std::int64_t count) {
      output.narrow(1, first, count).copy_(torch::addmm(bias.narrow(0, first, count), input, weight.narrow(0, first, count).t()));
    });
    return output;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& gradients) {
    const torch::Tensor input = context->get_saved_variables()[0], weight = context->get_saved_variables()[1];
    const torch::Tensor& gradient = gradients[0];
    const std::int64_t threads = context->saved_data["threads"].toInt();
    const torch::Tensor of_input = torch::empty_like(input), of_weight = torch::empty_like(weight);
    share(weight.size(0), threads, [&](std::int64_t first, std::int64_t count) {
      torch::Tensor rows = of_weight.narrow(0, first, count);
      torch::mm_out(rows, gradient.narrow(1, first, count).t(), input);
    });
    share(input.size(0), threads, [&](std::int64_t first, std::int64_t count) {
      torch::Tensor rows = of_input.narrow(0, first, count);
      torch::mm_out(rows, gradient.narrow(0, first, count), weight);
    });
    return {of_input, of_weight, gradient.sum(0), torch::Tensor()};
  }

 private:
  template <class Work>
  static void share(std::int64_t count, std::int64_t threads, const Work& work) {
    parallel_for(static_cast<std::size_t>(threads), static_cast<unsigned>(threads), [&](std::size_t i) {
      const torch::NoGradGuard no_gradients;  // of each thread
      const auto part = static_cast<std::int64_t>(i);
      const std::int64_t first = count * part / threads, end = count * (part + 1) / threads;
      if (end > first) work(first, end - first);
    });
  }
};

/// OpenBLAS has threads of its own, which would work beside those asked for. False where another library is the BLAS.
bool keep_blas_to_one_thread() {
  using SetThreads = void (*)(int);
  static const bool kept = [] {
    const auto set_blas_threads = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set_blas_threads != nullptr) set_blas_threads(1);
    return set_blas_threads != nullptr;
  }();
  return kept;
}

/// OpenBLAS takes 128 MB for each thread that calls it, and asks without end where it does not get them: there is room for these
/// and as much again for the rest, or the work does not begin. @throws Error  if there is not
void check_room_for_blas(unsigned threads) {
  static std::mutex guard;
  static unsigned checked = 0;
  const std::scoped_lock lock(guard);
  if (threads <= checked) return;
  const std::size_t bytes = (threads - checked) * (std::size_t{256} << 20);
  void* const room = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) {
    throw Error("memory: there is no room for another " + std::to_string(bytes >> 20) + " MB, which the network takes on " +
                std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
                "; expected a higher limit (ulimit -v), or fewer --threads");
  }
  ::munmap(room, bytes);
  checked = threads;
}

void set_threads(unsigned threads) {
  if (keep_blas_to_one_thread()) check_room_for_blas(threads);
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

void check_shapes(const Weights& weights, const std::vector<ParameterShape>& shapes, const std::string& what) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (weights.size() != shapes.size() || weights[i].shape != shapes[i] || weights[i].values.size() != shapes[i].count())
      throw Error(what + "; expected " + shapes[i].name + " " + nlohmann::json(shapes[i].sizes).dump());
  }
}

/// The moments an optimizer keeps, by the names that its papers and libtorch give them.
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

/// Under what an optimizer keeps its state of a parameter: its address, as a text in libtorch before 2.0.
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
  std::shared_ptr<Network> network;
};

LeNet::LeNet(SensorSize input, std::uint64_t seed, const LeNetOptions& options) : state_(std::make_unique<State>()) {
  state_->layers = lenet_layers(input);
  torch::manual_seed(seed);
  state_->network = std::make_shared<Network>(state_->layers, options);
}

LeNet::LeNet(SensorSize input, const Weights& weights, const LeNetOptions& options) : LeNet(input, 0, options) {
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
      trained = std::make_shared<Network>(of.layers(), of.state_->network->options);
      const torch::NoGradGuard no_gradients;
      const auto from = of.state_->network->parameters(), to = trained->parameters();
      for (std::size_t i = 0; i < to.size(); ++i) torch::Tensor(to[i]).copy_(from[i]);
      trained->to(torch::kFloat64);
    }
    parameters = trained->parameters();
    if (fast && trained->options == LeNetOptions{}) batch = std::make_unique<FusedBatch>(of.layers(), threads);
    if (fast)
      forget();
    else
      optimizer = make_optimizer(kind, parameters);
    torch::Tensor tensor = torch::empty({static_cast<std::int64_t>(touch_count)}, parameters[0].options().requires_grad(false));
    for (std::size_t i = 0; i < touch_count; ++i) tensor[static_cast<std::int64_t>(i)] = weights[i];
    const bool all_alike = std::all_of(weights.begin(), weights.end(), [](double weight) { return weight == 1.0; });
    if (!all_alike) loss_options.weight(tensor);
  }

  /// The fast engine's moments, as they are before the first step.
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
    if (threads == 1) return trained->connected(flat);
    return trained->connected_behind(
        SharedLinear::apply(flat, trained->fc1->weight, trained->fc1->bias, static_cast<std::int64_t>(threads)));
  }

  /// @return whether the slope is finite and no accident
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
    constexpr std::size_t piece = 65536;  // values that a thread takes at once
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
  std::shared_ptr<Network> trained;  ///< the network's own, or its like in float64
  OptimizerKind kind;
  bool fast;
  std::vector<torch::Tensor> parameters;               ///< of `trained`, in the order of the layers
  std::unique_ptr<FusedBatch> batch;                   ///< null where the layers are libtorch's
  std::unique_ptr<torch::optim::Optimizer> optimizer;  ///< null where the steps are ours, with
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
  const std::size_t count = count_of(heatmaps, state_->network.layers().input);
  if (count == 0 || count != truth.size()) {
    throw Error("training batch: " + std::to_string(count) + " heatmaps for " + std::to_string(truth.size()) +
                " touches; expected one each, and at least one");
  }
  set_threads(state_->threads);
  const torch::Tensor targets = torch::empty({static_cast<std::int64_t>(count)}, torch::kInt64);
  std::transform(truth.begin(), truth.end(), targets.data_ptr<std::int64_t>(),
                 [](Touch touch) { return static_cast<std::int64_t>(touch); });
  for (torch::Tensor& parameter : state_->parameters) parameter.mutable_grad().reset();  // zeros would be added to
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

}  // namespace tactile
