#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::evaluation {

/// Two hidden layers of 32 with ReLU on standardised features, three logits. Trained by Adam (rate 0.001, batches of 256, ten
/// passes) on the mean cross-entropy.
class FeatureNetwork {
 public:
  FeatureNetwork() = default;

  /// @param features  [n, size]   @param truth  of each of the n; at least one
  /// @throws Error    if the sizes do not fit
  FeatureNetwork(std::span<const float> features, std::size_t size, std::span<const Touch> truth);

  /// @param features  [n, size]
  std::vector<model::Probabilities> predict(std::span<const float> features) const;

 private:
  struct Layer {
    std::size_t inputs = 0, units = 0;
    std::vector<float> weights{};  ///< [units, inputs], then the bias [units]
  };

  void train(std::span<const float> features, std::span<const Touch> truth, Random& random);
  /// @param gradient  of the loss by the logits   @param gradients  of each layer's weights: get theirs
  void propagate_back(const std::vector<float>& input, const std::vector<std::vector<float>>& outputs,
                      std::vector<float> gradient, std::vector<std::vector<float>>& gradients) const;
  std::vector<float> standardised(std::span<const float> features) const;
  std::vector<std::vector<float>> outputs_of(std::span<const float> batch) const;

  std::size_t size_ = 0;
  std::vector<float> mean_{}, deviation_{};
  std::vector<Layer> layers_{};
};

}  // namespace tactile::evaluation
