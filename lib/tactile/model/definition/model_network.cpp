#include "tactile/model/definition/model_network.hpp"

#include <fmt/core.h>

#include "tactile/core/error.hpp"

namespace tactile::model {

events::SensorSize input_of(const ModelSettings& settings, events::SensorSize sensor) {
  return reads_heatmaps(settings.kind) ? heatmaps::heatmap_size(sensor, settings.rendering.factor) : sensor;
}

std::string input_text(ModelKind kind, events::SensorSize input) {
  return reads_heatmaps(kind) ? fmt::format("heatmaps of {} x {} cells", input.width, input.height)
                              : fmt::format("events of a sensor of {} x {} px", input.width, input.height);
}

std::vector<ParameterShape> parameters_of(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::own)
    throw Error("a network of one's own has no weights of a bundle; expected a model that tactile trained");
  if (settings.kind == ModelKind::lenet) return lenet_layers(input).parameters();
  check_fields(settings.stream, "training of kind stream");
  return stream_parameters();
}

nlohmann::json network_json(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::lenet) return json_of(lenet_layers(input), settings.network);
  std::size_t parameters = 0;
  for (const ParameterShape& shape : parameters_of(settings, input)) parameters += shape.count();
  nlohmann::json json = {{"name", name_of(settings.kind)},
                         {"input",
                          {{"height", input.height},
                           {"width", input.width},
                           {"places", StreamLayout::places},
                           {"features", StreamLayout::inputs_of_place}}},
                         {"parameters", parameters}};
  json.update(nlohmann::json(settings).at("network"));
  return json;
}

}  // namespace tactile::model
