#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/definition/training_options.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

class LeNetOnTorch;
class TrainerOnTorch;

/// The network on libtorch, which is loaded for the first one.
class LeNet {
 public:
  /// With libtorch's default initialisation for this seed. @throws Error  as `lenet_layers`, or if libtorch cannot be loaded
  LeNet(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options = {});

  /// @throws Error  if the weights have other shapes, or as the other constructor
  LeNet(events::SensorSize input, const Weights& weights, const LeNetOptions& options = {});
  ~LeNet();
  LeNet(LeNet&&) noexcept;
  LeNet& operator=(LeNet&&) noexcept;

  const LeNetLayers& layers() const;
  Weights weights() const;

  /// @param heatmaps  [n, height, width]; the network's input is H / 255
  /// @param threads   > 0; the logits do not depend on it
  /// @return n times the logits of none, press, slip
  /// @throws Error  if the size is not a whole number of heatmaps, or a logit exceeds float32
  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

 private:
  friend class LeNetTrainer;
  std::unique_ptr<LeNetOnTorch> on_torch_;
};

/// The result of one training step, before the weights change.
struct BatchResult {
  double loss = 0;           ///< cross-entropy of the batch, each sample weighted by its class
  double weight = 0;         ///< of the batch's samples together
  std::size_t correct = 0;   ///< of the batch
  double gradient_norm = 0;  ///< Euclidean, over all weights

  /// Whether the weights were changed. They are not if the loss or the gradient is not finite, or its norm exceeds
  /// `largest_gradient_norm`.
  bool moved = false;
};

/// A larger gradient is an error: cross-entropy on heatmaps in [0, 1] gives a few units.
inline constexpr double largest_gradient_norm = 1e6;

/// The state of an optimizer: one or two moments for each weight, named "optimizer.exp_avg.conv1.weight" etc.
struct OptimizerState {
  std::int64_t step = 0;  ///< number of steps
  Weights moments;

  friend bool operator==(const OptimizerState&, const OptimizerState&) = default;
};

/// The moments that an optimizer keeps for these parameters.
std::vector<ParameterShape> moment_shapes(OptimizerKind optimizer, const std::vector<ParameterShape>& parameters);

struct TrainerOptions {
  EngineKind engine = EngineKind::fast;  ///< uses libtorch's layers if they are not the paper's

  /// Computes in float64 with libtorch's layers, several times slower, to measure the error of float32. The network's weights and
  /// the state are rounded.
  bool float64 = false;
};

/// Changes a network's weights against the gradient of the cross-entropy.
class LeNetTrainer {
 public:
  /// @param network        trained in place; must outlive this
  /// @param class_weights  weight of the samples of each class, > 0
  /// @param threads        number of threads, > 0
  LeNetTrainer(LeNet& network, OptimizerKind optimizer, const std::array<double, touch_count>& class_weights, unsigned threads,
               const TrainerOptions& options = {});
  ~LeNetTrainer();

  /// One step on one batch. @throws Error  if there is not one heatmap for each touch
  BatchResult learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate);

  /// The state, besides the weights, that the next step depends on. Call it after a step.
  OptimizerState state() const;

  /// Resumes from `state`. @throws Error  if it does not fit this optimizer and network
  void restore(const OptimizerState& state);

 private:
  std::unique_ptr<TrainerOnTorch> on_torch_;
};

}  // namespace tactile::model
