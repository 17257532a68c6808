#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/inference/stream_network.hpp"
#include "tactile/model/torch/torch_part.hpp"
#include "tactile/model/torch/torch_training.hpp"

namespace tactile::model {
namespace {

using Clock = std::chrono::steady_clock;
using Sizes = StreamSizes;
constexpr std::int64_t channels = Sizes::channels, memory = Sizes::memory, places = StreamLayout::places;
constexpr std::int64_t cells = StreamLayout::cells_of_place, inputs_of_place = cells + 1;
constexpr std::int64_t crops = StreamCrops::crops, ticks_of_crop = StreamCrops::ticks;
constexpr double highest_rate = 0.006;
constexpr unsigned steps_of_epoch = 100;

/// m(t) = (1 - 1/T) m(t - 1) + x(t) / T from m = 0, of all ticks at once: within blocks of ticks by one product, from block to
/// block by what is left of the last mean. A loop over ticks is ten times slower.
/// @param x  [crop, tick, value]
torch::Tensor running_mean(const torch::Tensor& x, double span) {
  constexpr std::int64_t block = 50;
  const std::int64_t count = x.size(0), ticks = x.size(1), values = x.size(2), blocks = (ticks + block - 1) / block;
  const double kept = 1 - 1 / span;
  const torch::Tensor k = torch::arange(block, torch::kFloat32);
  const torch::Tensor apart = k.unsqueeze(1) - k.unsqueeze(0);
  const torch::Tensor within = torch::pow(kept, apart.clamp_min(0)) * (apart >= 0).to(torch::kFloat32) / span;
  const torch::Tensor since = torch::pow(kept, k + 1).reshape({1, block, 1});
  const torch::Tensor padded =
      torch::constant_pad_nd(x, {0, 0, 0, blocks * block - ticks}).reshape({count, blocks, block, values});
  const torch::Tensor alone = torch::matmul(within, padded);
  torch::Tensor last = torch::zeros({count, 1, values});
  std::vector<torch::Tensor> means;
  for (std::int64_t i = 0; i < blocks; ++i) {
    means.push_back(alone.select(1, i) + since * last);
    last = means.back().slice(1, block - 1);
  }
  return torch::cat(means, 1).slice(1, 0, ticks);
}

/// x and y of each place, from -1 to 1: [2, places].
torch::Tensor positions() {
  torch::Tensor at = torch::empty({2, places});
  for (std::size_t place = 0; place < StreamLayout::places; ++place) {
    at.data_ptr<float>()[place] = position_of(place % StreamLayout::across, StreamLayout::across);
    at.data_ptr<float>()[StreamLayout::places + place] = position_of(place / StreamLayout::across, StreamLayout::down);
  }
  return at;
}

/// The network after its first layer.
struct StreamModule : torch::nn::Module {
  StreamModule()
      : means(Sizes::kept * channels, channels),
        place(channels, channels),
        gru(torch::nn::GRUOptions(Sizes::pooled, memory).batch_first(true)),
        out(memory, static_cast<std::int64_t>(touch_count)) {
    register_module("means", means);
    register_module("place", place);
    register_module("gru", gru);
    register_module("out", out);
  }

  /// @param a  [crop, tick, place, channel] @return  [crop, tick, class]
  torch::Tensor forward(const torch::Tensor& a) {
    const std::int64_t count = a.size(0), ticks = a.size(1);
    std::vector<torch::Tensor> kept{a};
    for (const double span : Sizes::spans)
      kept.push_back(running_mean(a.reshape({count, ticks, places * channels}), span).reshape({count, ticks, places, channels}));
    const torch::Tensor u = torch::relu(place->forward(torch::relu(means->forward(torch::cat(kept, 3)))));
    const torch::Tensor moments = torch::matmul(at / static_cast<double>(places), u);  // [crop, tick, 2, channel]
    const torch::Tensor pooled = torch::cat({u.mean(2), std::get<0>(u.max(2)), moments.select(2, 0), moments.select(2, 1)}, 2);
    return out->forward(std::get<0>(gru->forward(pooled)));
  }

  torch::nn::Linear means, place;
  torch::nn::GRU gru;
  torch::nn::Linear out;
  torch::Tensor at = positions();
};

/// The counts of a place by their principal components, each of unit variance; the logarithm of the sum is standardised.
struct Whitening {
  torch::Tensor mean;     ///< [inputs of a place]
  torch::Tensor project;  ///< [inputs of a place, channels + 1]

  explicit Whitening(const torch::Tensor& inputs) {
    const torch::Tensor all = inputs.reshape({-1, inputs_of_place}).to(torch::kFloat64);
    const torch::Tensor of_cells = all.slice(1, 0, cells), of_sum = all.select(1, cells);
    const torch::Tensor centred = of_cells - of_cells.mean(0);
    const auto [squares, vectors] = torch::linalg_eigh(torch::matmul(centred.t(), centred) / all.size(0));
    const torch::Tensor deviations = squares.slice(0, cells - channels).clamp_min(0).sqrt();
    torch::Tensor columns = torch::zeros({inputs_of_place, channels + 1}, torch::kFloat64);
    columns.slice(0, 0, cells).slice(1, 0, channels).copy_(vectors.slice(1, cells - channels) / (deviations + 1e-3));
    columns.index_put_({cells, channels}, 1 / (of_sum.std() + 1e-3));
    mean = all.mean(0).to(torch::kFloat32);
    project = columns.to(torch::kFloat32);
  }

  torch::Tensor forward(const torch::Tensor& inputs) const { return torch::matmul(inputs - mean, project); }
};

double rate_at(std::uint64_t step, std::uint64_t steps) {
  constexpr double rising = 0.3, first = highest_rate / 25;
  const double done = static_cast<double>(step) / static_cast<double>(steps);
  const auto along = [](double from, double to, double share) {
    return to + (from - to) * (1 + std::cos(std::numbers::pi * share)) / 2;
  };
  return done < rising ? along(first, highest_rate, done / rising) : along(highest_rate, 0, (done - rising) / (1 - rising));
}

torch::Tensor inputs_of(const StreamBatch& batch) {
  return torch::from_blob(const_cast<float*>(batch.inputs.data()), {crops, ticks_of_crop, places, inputs_of_place});  // NOLINT
}

struct StreamTraining {
  const StreamCrops& crops_of;
  Whitening whitening;
  torch::nn::Linear first{channels + 1, channels};
  StreamModule network{};
  std::vector<torch::Tensor> parameters{};
  std::unique_ptr<torch::optim::AdamW> optimizer{};

  void begin() {
    parameters = network.parameters();
    for (const torch::Tensor& parameter : first->parameters()) parameters.push_back(parameter);
    optimizer = std::make_unique<torch::optim::AdamW>(parameters, torch::optim::AdamWOptions(highest_rate).weight_decay(0.01));
  }

  /// Adds what a step gives to the epoch, as sums.
  void step(std::uint64_t number, std::uint64_t steps, EpochResult& epoch) {
    const StreamBatch batch = crops_of.batch(number, 1);
    const torch::Tensor truth = torch::tensor(batch.truth), weights = torch::tensor(batch.weights);
    epoch.learning_rate = rate_at(number, steps);
    for (torch::optim::OptimizerParamGroup& group : optimizer->param_groups())
      static_cast<torch::optim::AdamWOptions&>(group.options()).lr(epoch.learning_rate);
    optimizer->zero_grad();
    const torch::Tensor logits = network.forward(torch::relu(first->forward(whitening.forward(inputs_of(batch)))))
                                     .reshape({-1, static_cast<std::int64_t>(touch_count)});
    const torch::Tensor losses = torch::nn::functional::cross_entropy(
        logits, truth, torch::nn::functional::CrossEntropyFuncOptions().reduction(torch::kNone));
    const torch::Tensor sum = weights.sum().clamp_min(1);
    const torch::Tensor loss = (losses * weights).sum() / sum;
    loss.backward();
    epoch.gradient_norm = std::max(epoch.gradient_norm, torch::nn::utils::clip_grad_norm_(parameters, 1));
    const auto value = loss.item<double>();
    if (!std::isfinite(value))
      throw Error(fmt::format("training of kind stream: the loss is {} at step {}; expected a finite one", value, number + 1));
    optimizer->step();
    epoch.loss += value;
    epoch.accuracy += ((logits.argmax(1) == truth).to(torch::kFloat32) * weights).sum().item<double>() / sum.item<double>();
  }

  /// The first layer takes the counts themselves: W x + b with W = F P^T, b = f - F P^T mean.
  Weights weights(const StreamGrid& grid) const {
    const torch::Tensor whole = torch::matmul(first->weight.to(torch::kFloat64), whitening.project.to(torch::kFloat64).t());
    const torch::Tensor bias = first->bias.to(torch::kFloat64) - torch::matmul(whole, whitening.mean.to(torch::kFloat64));
    const std::vector<ParameterShape> shapes = stream_parameters();
    Weights weights{{shapes[0],
                     {static_cast<float>(grid.left), static_cast<float>(grid.top), static_cast<float>(grid.right),
                      static_cast<float>(grid.bottom)}},
                    {shapes[1], values_of(whole)},
                    {shapes[2], values_of(bias)}};
    const auto named = network.named_parameters();
    for (std::size_t i = 3; i < shapes.size(); ++i) {
      const std::string& name = shapes[i].name;
      weights.push_back({shapes[i], values_of(named[name.starts_with("gru.") ? name + "_l0" : name])});
    }
    return weights;
  }
};

/// Inputs of ticks of the runs as they are, drawn at random.
torch::Tensor inputs_to_whiten(std::span<const StreamRun> runs, std::uint64_t seed) {
  constexpr std::size_t of_each = 400;
  Random random(seed_for(seed, {"whitening"}));
  torch::Tensor inputs = torch::empty({static_cast<std::int64_t>(runs.size() * of_each), places, inputs_of_place});
  float* next = inputs.data_ptr<float>();
  for (const StreamRun& run : runs) {
    for (std::size_t i = 0; i < of_each; ++i, next += places * inputs_of_place)
      stream_inputs(run.at(random.below(run.ticks)), {next, static_cast<std::size_t>(places * inputs_of_place)});
  }
  return inputs;
}

}  // namespace

FittedStream fit_stream_on_torch(std::span<const StreamRun> runs, const StreamGrid& grid, const StreamOptions& options,
                                 std::uint64_t seed, const ProgressCallback& progress,
                                 const std::function<void(const std::vector<EpochResult>& finished)>& on_epoch) {
  check(grid);
  use_one_thread();
  const StreamCrops crops_of(runs, seed);
  torch::manual_seed(seed);
  StreamTraining training{crops_of, Whitening(inputs_to_whiten(runs, seed))};
  training.begin();
  FittedStream fitted;
  EpochResult epoch;
  auto begun = Clock::now();
  for (unsigned step = 0; step < options.steps; ++step) {
    training.step(step, options.steps, epoch);
    const unsigned in_epoch = step % steps_of_epoch + 1;
    if (in_epoch == steps_of_epoch || step + 1 == options.steps) {
      epoch.epoch = static_cast<unsigned>(fitted.history.size()) + 1;
      epoch.loss /= in_epoch;
      epoch.accuracy /= in_epoch;
      epoch.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
      epoch.images_per_s = static_cast<double>(in_epoch * crops * ticks_of_crop) / epoch.seconds;
      fitted.history.push_back(epoch);
      if (on_epoch) on_epoch(fitted.history);
      epoch = {};
      begun = Clock::now();
    }
    if ((step + 1) % 10 == 0 && !fitted.history.empty())
      report_progress(progress, step + 1, options.steps,
                      fmt::format("step {}/{}: loss {:.4f}", step + 1, options.steps, fitted.history.back().loss));
    else if ((step + 1) % 10 == 0)
      report_progress(progress, step + 1, options.steps, fmt::format("step {}/{}", step + 1, options.steps));
  }
  fitted.weights = training.weights(grid);
  check_finite(fitted.weights, "training");
  return fitted;
}

std::vector<Logits> stream_logits_on_torch(std::span<const float> inputs, const Weights& weights) {
  check_shapes(weights, stream_parameters(), "a model of kind stream with other parameters");
  use_one_thread();
  const torch::NoGradGuard no_gradients;
  const auto tensor_of = [&](std::size_t i) { return torch::tensor(weights[i].values).reshape(weights[i].shape.sizes); };
  StreamModule network;
  auto named = network.named_parameters();
  for (std::size_t i = 3; i < weights.size(); ++i) {
    const std::string& name = weights[i].shape.name;
    named[name.starts_with("gru.") ? name + "_l0" : name].copy_(tensor_of(i));
  }
  const auto ticks = static_cast<std::int64_t>(inputs.size()) / (places * inputs_of_place);
  const torch::Tensor x = torch::from_blob(const_cast<float*>(inputs.data()), {1, ticks, places, inputs_of_place});  // NOLINT
  const std::vector<float> values = values_of(network.forward(torch::relu(torch::linear(x, tensor_of(1), tensor_of(2)))));
  std::vector<Logits> logits(values.size() / touch_count);
  for (std::size_t i = 0; i < values.size(); ++i) logits[i / touch_count][i % touch_count] = values[i];
  return logits;
}

}  // namespace tactile::model
