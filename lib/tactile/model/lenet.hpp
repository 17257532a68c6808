#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/model/lenet_layers.hpp"
#include "tactile/model/logits.hpp"
#include "tactile/model/weights.hpp"

namespace tactile {

/// The network itself, on libtorch.
class LeNet {
 public:
  /// libtorch's default initialisation after its generator was seeded. @throws Error as `lenet_layers`
  LeNet(SensorSize input, std::uint64_t seed);

  /// @throws Error  if the weights are not of this network's shapes, or as `lenet_layers`
  LeNet(SensorSize input, const Weights& weights);
  ~LeNet();
  LeNet(LeNet&&) noexcept;
  LeNet& operator=(LeNet&&) noexcept;

  const LeNetLayers& layers() const;
  Weights weights() const;

  /// @param heatmaps  [n, height, width], one after the other; the network sees them as H / 255
  /// @param threads   > 0; the logits do not depend on it
  /// @return n times the logits of none, press, slip
  /// @throws Error  if the heatmaps are no whole number of this network's input
  std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const;

 private:
  friend class LeNetTrainer;
  struct State;
  std::unique_ptr<State> state_;
};

/// What one training step found before it moved the weights.
struct BatchResult {
  double loss = 0;          ///< mean cross-entropy of the batch
  std::size_t correct = 0;  ///< of the batch
};

/// Moves a network's weights down the slope of the cross-entropy by Adam (betas 0.9 and 0.999, epsilon 1e-8).
class LeNetTrainer {
 public:
  /// @param network        trained in place; must outlive this
  /// @param learning_rate  > 0
  /// @param threads        libtorch works on, > 0
  LeNetTrainer(LeNet& network, double learning_rate, unsigned threads);
  ~LeNetTrainer();

  /// One step on one batch. @throws Error  if there is not one heatmap for each touch
  BatchResult learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
