#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/model/definition/model_settings.hpp"

namespace tactile::model {

/// The size of a model's input: of a heatmap [cells], or, of stream, of the sensor [px].
events::SensorSize input_of(const ModelSettings& settings, events::SensorSize sensor);

/// "heatmaps of 128 x 96 cells", or "events of a sensor of 640 x 480 px"
std::string input_text(ModelKind kind, events::SensorSize input);

/// The parameters in the weights file of a model.
/// @throws Error  if a heatmap of this size does not suit the network, or an option is out of its range
std::vector<ParameterShape> parameters_of(const ModelSettings& settings, events::SensorSize input);

/// What a bundle's model.json has as "network". @throws Error  as `parameters_of`
nlohmann::json network_json(const ModelSettings& settings, events::SensorSize input);

}  // namespace tactile::model
