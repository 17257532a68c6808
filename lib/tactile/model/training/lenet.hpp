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

namespace tactile {

/// The network itself, on libtorch.
class LeNet {
 public:
  /// libtorch's default initialisation after its generator was seeded. @throws Error as `lenet_layers`
  LeNet(SensorSize input, std::uint64_t seed, const LeNetOptions& options = {});

  /// @throws Error  if the weights are not of this network's shapes, or as `lenet_layers`
  LeNet(SensorSize input, const Weights& weights, const LeNetOptions& options = {});
  ~LeNet();
  LeNet(LeNet&&) noexcept;
  LeNet& operator=(LeNet&&) noexcept;

  const LeNetLayers& layers() const;
  Weights weights() const;

  /// @param heatmaps  [n, height, width], one after the other; the network sees them as H / 255
  /// @param threads   > 0; the logits do not depend on it
  /// @return n times the logits of none, press, slip
  /// @throws Error  if the heatmaps are no whole number of this network's input, or the weights are so large that a logit leaves
  ///                float32
  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

 private:
  friend class LeNetTrainer;
  struct State;
  std::unique_ptr<State> state_;
};

/// What one training step found before it moved the weights.
struct BatchResult {
  double loss = 0;           ///< cross-entropy of the batch, each sample weighted by its class
  double weight = 0;         ///< of the batch's samples together
  std::size_t correct = 0;   ///< of the batch
  double gradient_norm = 0;  ///< Euclidean, over all weights

  /// Whether the weights were moved: not by a loss or a slope that is not finite, or a slope above `largest_gradient_norm`.
  bool moved = false;
};

/// Above it a slope is an accident: cross-entropy on heatmaps in [0, 1] gives a few units.
inline constexpr double largest_gradient_norm = 1e6;

/// What an optimizer remembers: for each weight a moment or two, named "optimizer.exp_avg.conv1.weight" and so on.
struct OptimizerState {
  std::int64_t step = 0;  ///< batches learned from
  Weights moments;

  friend bool operator==(const OptimizerState&, const OptimizerState&) = default;
};

/// The moments that an optimizer keeps for these parameters.
std::vector<ParameterShape> moment_shapes(OptimizerKind optimizer, const std::vector<ParameterShape>& parameters);

struct TrainerOptions {
  EngineKind engine = EngineKind::fast;  ///< which takes libtorch's layers where they are not the paper's

  /// Works in float64 with libtorch's layers, several times slower: what float32 costs is measured by it. The network's weights
  /// and the state are rounded.
  bool float64 = false;
};

/// Moves a network's weights down the slope of the cross-entropy.
class LeNetTrainer {
 public:
  /// @param network        trained in place; must outlive this
  /// @param class_weights  how much a sample of each class counts, > 0
  /// @param threads        it works on, > 0
  LeNetTrainer(LeNet& network, OptimizerKind optimizer, const std::array<double, touch_count>& class_weights, unsigned threads,
               const TrainerOptions& options = {});
  ~LeNetTrainer();

  /// One step on one batch. @throws Error  if there is not one heatmap for each touch
  BatchResult learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate);

  /// What the next step depends on beside the weights; to be asked for behind a step.
  OptimizerState state() const;

  /// Goes on as the trainer did that gave `state`. @throws Error  if it is none of this optimizer and network
  void restore(const OptimizerState& state);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
