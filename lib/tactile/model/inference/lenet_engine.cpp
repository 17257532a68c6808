#include "tactile/model/inference/lenet_engine.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/inference/flushed_denormals.hpp"
#include "tactile/model/inference/lenet_kernel.hpp"

namespace tactile::model {
namespace {

using Sizes = LeNetSizes;
constexpr std::size_t taps = Sizes::taps, in_channels = Sizes::first_channels, out_channels = Sizes::second_channels;
constexpr float largest_byte = 127;

constexpr std::size_t rounded_up(std::size_t value, std::size_t step) { return (value + step - 1) / step * step; }

std::size_t side(int cells) { return static_cast<std::size_t>(cells); }

/// An upper limit for a layer's outputs, if its inputs do not exceed `input`.
double largest_output(const Parameter& weight, const Parameter& bias, double input) {
  const std::size_t inputs = weight.values.size() / bias.values.size();
  double largest = 0;
  for (std::size_t i = 0; i < bias.values.size(); ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < inputs; ++k) sum += std::abs(static_cast<double>(weight.values[i * inputs + k]));
    largest = std::max(largest, std::abs(static_cast<double>(bias.values[i])) + sum * input);
  }
  return largest;
}

/// If no sum can exceed float32, no value becomes infinite or NaN.
void check_range(const Weights& weights) {
  constexpr double margin = 64;  // for differences, rounding, and the points of the second convolution
  double input = 1;
  for (std::size_t i = 0; i < weights.size(); i += 2) {
    input = largest_output(weights[i], weights[i + 1], input);
    if (input * margin > static_cast<double>(std::numeric_limits<float>::max())) {
      throw Error("weights: up to " + weights[i].shape.name +
                  " they are so large that sums may exceed float32; expected smaller ones, or --engine libtorch");
    }
  }
}

void set_sizes(LeNetPlan& plan) {
  const events::SensorSize first = plan.layers.first_pooled;
  plan.input_rows = 2 * side(first.height) + taps - 1;
  plan.input_pairs = side(first.width) + taps / 2;
  plan.pair_chunks = rounded_up(plan.input_pairs, Sizes::lanes) / Sizes::lanes + 1;
  plan.pair_stride = plan.pair_chunks * Sizes::lanes;
  plan.blocks = rounded_up(side(plan.layers.second_pooled.width), Sizes::block) / Sizes::block;
  const std::size_t columns = rounded_up(plan.blocks * Sizes::block, Sizes::lanes);
  plan.pooled_stride = rounded_up(std::max(side(first.width), 2 * columns + taps), Sizes::lanes) + Sizes::lanes;
}

void set_convolutions(LeNetPlan& plan, const Weights& weights) {
  plan.first_weights.resize(taps * taps * in_channels);
  for (std::size_t c = 0; c < in_channels; ++c) {
    for (std::size_t tap = 0; tap < taps * taps; ++tap)
      plan.first_weights[tap * in_channels + c] = weights[0].values[c * taps * taps + tap];
  }
  plan.first_bias.assign(weights[1].values.begin(), weights[1].values.end());
  // Winograd's F(2, 5) at 0, 1, -1, 2, -2 and infinity.
  constexpr double points[Sizes::points][taps] = {
      {1.0 / 4, 0, 0, 0, 0},
      {-1.0 / 6, -1.0 / 6, -1.0 / 6, -1.0 / 6, -1.0 / 6},
      {-1.0 / 6, 1.0 / 6, -1.0 / 6, 1.0 / 6, -1.0 / 6},
      {1.0 / 24, 2.0 / 24, 4.0 / 24, 8.0 / 24, 16.0 / 24},
      {1.0 / 24, -2.0 / 24, 4.0 / 24, -8.0 / 24, 16.0 / 24},
      {0, 0, 0, 0, 1},
  };
  plan.second_weights.resize(Sizes::points * in_channels * taps * out_channels);
  for (std::size_t point = 0; point < Sizes::points; ++point) {
    for (std::size_t in = 0; in < in_channels; ++in) {
      for (std::size_t y = 0; y < taps; ++y) {
        for (std::size_t out = 0; out < out_channels; ++out) {
          double sum = 0;
          for (std::size_t x = 0; x < taps; ++x)
            sum += points[point][x] * static_cast<double>(weights[2].values[((out * in_channels + in) * taps + y) * taps + x]);
          plan.second_weights[((point * in_channels + in) * taps + y) * out_channels + out] = static_cast<float>(sum);
        }
      }
    }
  }
  plan.second_bias.assign(weights[3].values.begin(), weights[3].values.end());
  plan.second_empty.assign(out_channels, 0.0F);
  for (std::size_t c = 0; c < in_channels; ++c) plan.first_empty[c] = std::max(plan.first_bias[c], 0.0F);
}

/// A layer's weights as [input][outputs, rounded up], and its bias in the same layout.
void set_dense(AlignedValues<float>& rows, AlignedValues<float>& bias, const Parameter& weight, const Parameter& bias_in,
               std::size_t row) {
  const std::size_t outputs = bias_in.values.size(), inputs = weight.values.size() / outputs;
  rows.assign(inputs * row, 0.0F);
  bias.assign(row, 0.0F);
  for (std::size_t out = 0; out < outputs; ++out) {
    bias[out] = bias_in.values[out];
    for (std::size_t in = 0; in < inputs; ++in) rows[in * row + out] = weight.values[out * inputs + in];
  }
}

/// The first fully connected layer, with its inputs in channel-last order.
void set_hidden(LeNetPlan& plan, const Parameter& weight) {
  const std::size_t pixels = plan.layers.flat / out_channels;
  plan.hidden_weights.assign(plan.layers.flat * Sizes::hidden_row, 0.0F);
  for (std::size_t out = 0; out < Sizes::first_hidden; ++out) {
    const float* in = &weight.values[out * plan.layers.flat];
    for (std::size_t channel = 0; channel < out_channels; ++channel) {
      for (std::size_t pixel = 0; pixel < pixels; ++pixel)
        plan.hidden_weights[(pixel * out_channels + channel) * Sizes::hidden_row + out] = in[channel * pixels + pixel];
    }
  }
}

/// The nearest finite bfloat16, the one with an even last bit of two. Highway's conversion truncates.
std::uint16_t nearest_bf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto nearest = static_cast<std::uint16_t>((bits + 0x7FFF + (bits >> 16 & 1)) >> 16);
  constexpr std::uint16_t infinity = 0x7F80;
  return (nearest & 0x7FFF) == infinity ? static_cast<std::uint16_t>(nearest - 1) : nearest;
}

/// Stores the first fully connected layer's weights in another format. With bfloat16 those in float32 are rounded alike, because
/// `set_hidden_empty` reads them.
void set_precision(LeNetPlan& plan, Precision precision) {
  AlignedValues<float>& weights = plan.hidden_weights;
  if (precision == Precision::bf16) {
    plan.hidden_bf16.resize(weights.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      plan.hidden_bf16[i] = nearest_bf16(weights[i]);
      weights[i] = std::bit_cast<float>(std::uint32_t{plan.hidden_bf16[i]} << 16);
    }
  } else if (precision == Precision::int8) {
    plan.hidden_bytes.resize(weights.size());
    plan.hidden_scale.assign(Sizes::hidden_row, 0.0F);
    for (std::size_t out = 0; out < Sizes::first_hidden; ++out) {
      float largest = 0;
      for (std::size_t in = out; in < weights.size(); in += Sizes::hidden_row) largest = std::max(largest, std::abs(weights[in]));
      const double unit = static_cast<double>(largest) / largest_byte;
      plan.hidden_scale[out] = static_cast<float>(unit);
      if (unit == 0) continue;
      for (std::size_t in = out; in < weights.size(); in += Sizes::hidden_row)
        plan.hidden_bytes[in] = static_cast<std::int8_t>(std::lround(static_cast<double>(weights[in]) / unit));
    }
  }
}

/// The sums of the first fully connected layer for an empty heatmap, with the same weights as for others.
void set_hidden_empty(LeNetPlan& plan, const Parameter& bias) {
  plan.hidden_empty.assign(Sizes::hidden_row, 0.0F);
  for (std::size_t out = 0; out < Sizes::first_hidden; ++out) {
    double sum = 0;
    for (std::size_t in = 0; in < plan.layers.flat; ++in) {
      const std::size_t place = in * Sizes::hidden_row + out;
      sum += static_cast<double>(plan.second_empty[in % out_channels]) *
             (plan.hidden_bytes.empty() ? static_cast<double>(plan.hidden_weights[place])
                                        : static_cast<double>(plan.hidden_bytes[place]) * plan.hidden_scale[out]);
    }
    plan.hidden_empty[out] = static_cast<float>(sum + bias.values[out]);
  }
}

LeNetKernel kernel_named(const std::string& name) {
  if (name.empty()) return best_kernel();
  std::string known;
  for (const LeNetKernel& kernel : kernels()) {
    if (name == kernel.name) return kernel;
    known += (known.empty() ? "" : ", ") + std::string(kernel.name);
  }
  throw Error("vector instructions '" + name + "': not available here; expected one of " + known);
}

}  // namespace

std::string_view name_of(Precision precision) { return precision_names.at(static_cast<std::size_t>(precision)); }
Precision precision_named(std::string_view name) { return enumerator_named<Precision>(name, precision_names, "precision"); }

struct LeNetEngine::State {
  std::shared_ptr<const LeNetPlan> plan;
  LeNetKernel kernel;
  bool skip_empty = true;
  LeNetMemory memory;
};

LeNetEngine::LeNetEngine(events::SensorSize input, const Weights& weights, const LeNetOptions& layers,
                         const EngineOptions& options) {
  if (!layers.is_fast()) {
    throw Error("network with " + std::string(name_of(layers.activation)) + " and " + std::string(name_of(layers.pooling)) +
                "-pooling: the fast engine does not support it; expected relu and max-pooling, or --engine libtorch");
  }
  auto plan = std::make_shared<LeNetPlan>();
  plan->layers = lenet_layers(input);
  check_shapes(weights, plan->layers.parameters(), "weights: not of this network");
  check_finite(weights, "weights");
  check_range(weights);
  const FlushedDenormals flushed;
  set_sizes(*plan);
  set_convolutions(*plan, weights);
  set_hidden(*plan, weights[4]);
  set_precision(*plan, options.precision);
  set_dense(plan->inner_weights, plan->inner_bias, weights[6], weights[7], Sizes::hidden_row);
  set_dense(plan->last_weights, plan->last_bias, weights[8], weights[9], Sizes::lanes);

  // The kernel itself computes the empty heatmap, so that the differences are exactly 0.
  const LeNetKernel kernel = kernel_named(options.target);
  LeNetMemory memory = memory_for(*plan);
  const std::vector<std::uint8_t> empty(side(input.width) * side(input.height));
  AlignedValues<float> second(plan->layers.flat);
  kernel.run(*plan, memory, empty.data(), false, nullptr, second.data());
  plan->second_empty.assign(second.begin(), second.begin() + out_channels);
  set_hidden_empty(*plan, weights[5]);
  if (options.precision != Precision::fp32) plan->hidden_weights = AlignedValues<float>();  // frees them, which {} does not
  kernel.run(*plan, memory, empty.data(), false, plan->logits_empty.data(), nullptr);
  state_ = std::make_unique<State>(State{plan, kernel, options.skip_empty, memory_for(*plan)});
}

LeNetEngine::~LeNetEngine() = default;
LeNetEngine::LeNetEngine(const LeNetEngine& other) : state_(std::make_unique<State>(*other.state_)) {}
LeNetEngine& LeNetEngine::operator=(const LeNetEngine& other) {
  if (this != &other) state_ = std::make_unique<State>(*other.state_);
  return *this;
}
LeNetEngine::LeNetEngine(LeNetEngine&&) noexcept = default;
LeNetEngine& LeNetEngine::operator=(LeNetEngine&&) noexcept = default;

const LeNetLayers& LeNetEngine::layers() const { return state_->plan->layers; }
std::string_view LeNetEngine::target() const { return state_->kernel.name; }

std::vector<std::string> LeNetEngine::targets() {
  std::vector<std::string> names;
  for (const LeNetKernel& kernel : kernels()) names.emplace_back(kernel.name);
  return names;
}

Logits LeNetEngine::classify(std::span<const std::uint8_t> heatmap) {
  const events::SensorSize size = state_->plan->layers.input;
  if (heatmap.size() != side(size.width) * side(size.height)) {
    throw Error("heatmap of " + std::to_string(heatmap.size()) + " bytes; expected one of " + std::to_string(size.width) + " x " +
                std::to_string(size.height) + " cells");
  }
  Logits logits{};
  const FlushedDenormals flushed;
  state_->kernel.run(*state_->plan, state_->memory, heatmap.data(), state_->skip_empty, logits.data(), nullptr);
  return logits;
}

}  // namespace tactile::model
