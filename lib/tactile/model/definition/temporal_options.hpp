#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// A causal temporal convolution over 16 steps of twelve features (`features::StepFeatures`).
struct TemporalOptions {
  unsigned channels = 32;  ///< of each layer, 1 to 64

  friend bool operator==(const TemporalOptions&, const TemporalOptions&) = default;
};

/// {"channels"}
void to_json(nlohmann::json& json, const TemporalOptions& options);
void from_json(const nlohmann::json& json, TemporalOptions& options);  ///< @throws Error

void check(const TemporalOptions& options);  ///< @throws Error  if an option is out of its range

/// Layers of convolutions: each halves the number of steps.
inline constexpr std::size_t temporal_layers = 4;

/// The parameters in a weights file: "input.mean" and "input.scale" [12]; of layer k from 1 to 4 "conv<k>.weight"
/// [channels, inputs, 2] and "conv<k>.bias" [channels]; "out.weight" [3, channels] and "out.bias" [3].
std::vector<ParameterShape> temporal_parameters(const TemporalOptions& options);

}  // namespace tactile::model
