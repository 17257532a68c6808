#include "tactile/model/definition/model_network.hpp"

#include <fmt/core.h>

#include "tactile/features/tick_features.hpp"

namespace tactile::model {

events::SensorSize input_of(const ModelSettings& settings, events::SensorSize sensor) {
  return reads_heatmaps(settings.kind) ? heatmaps::heatmap_size(sensor, settings.rendering.factor) : sensor;
}

std::string input_text(ModelKind kind, events::SensorSize input) {
  return reads_heatmaps(kind) ? fmt::format("heatmaps of {} x {} cells", input.width, input.height)
                              : fmt::format("events of a sensor of {} x {} px", input.width, input.height);
}

std::vector<ParameterShape> parameters_of(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::lenet) return lenet_layers(input, settings.network).parameters();
  check(settings.trees);
  return tree_parameters(settings.trees);
}

nlohmann::json network_json(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::lenet) return json_of(lenet_layers(input, settings.network), settings.network);
  std::size_t parameters = 0;
  for (const ParameterShape& shape : parameters_of(settings, input)) parameters += shape.count();
  nlohmann::json json = {{"name", "boosted-trees"},
                         {"kind", name_of(settings.kind)},
                         {"input", {{"height", input.height}, {"width", input.width}, {"features", features::feature_count}}},
                         {"parameters", parameters}};
  json.update(nlohmann::json(settings.trees));
  return json;
}

}  // namespace tactile::model
