#pragma once

#include <array>
#include <span>
#include <vector>

#include "tactile/features/step_features.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/temporal_options.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

/// The input of a temporal convolution: z = (feature - mean) * scale, limited to [-10, 10], so that no event rate that training
/// never saw makes a sum large.
inline constexpr float largest_step_value = 10;
void standardise(std::span<const float> features, std::span<const float> mean, std::span<const float> scale,
                 std::span<float> values);

/// A causal convolution over time whose last output is read. Layer k has kernels of 2 values that lie 2^(k-1) steps apart:
///
///   y_k(t) = relu(bias_k + W_k,0 y_{k-1}(t - 2^(k-1)) + W_k,1 y_{k-1}(t)),   y_0 = z,   logits = out y_4(last)
///
/// So the last output reads exactly the 16 steps that end with it. Of each layer only the outputs that it needs are computed: 8,
/// 4, 2 and 1. The logits agree with libtorch's within 1e-5 of the largest. Immutable and thread-safe; `logits` allocates no
/// memory.
///
/// Source of the method: van den Oord et al., WaveNet, arXiv:1609.03499, section 2.1.
class TemporalNetwork {
 public:
  /// @throws Error  if the weights have other shapes, or are so large that a sum may exceed float32
  TemporalNetwork(const TemporalOptions& options, const Weights& weights);

  /// @param features  [16, 12], the oldest step first, finite. @throws Error  if there are not that many
  Logits logits(std::span<const float> features) const;

 private:
  struct Layer {
    std::size_t inputs = 0, outputs = 0;
    std::vector<float> weights;  ///< [2 * inputs, outputs], so that outputs lie side by side
    std::vector<float> bias;
  };
  void check_range() const;

  std::vector<float> mean_, scale_;
  std::array<Layer, temporal_layers> layers_;
  Layer out_;
};

}  // namespace tactile::model
