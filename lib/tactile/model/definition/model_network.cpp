#include "tactile/model/definition/model_network.hpp"

#include <fmt/core.h>

#include "tactile/features/step_features.hpp"
#include "tactile/features/tick_features.hpp"

namespace tactile::model {
namespace {

const char* network_name(ModelKind kind) {
  return kind == ModelKind::stream ? "stream" : kind == ModelKind::trees ? "boosted-trees" : "temporal-convolution";
}

}  // namespace

events::SensorSize input_of(const ModelSettings& settings, events::SensorSize sensor) {
  return reads_heatmaps(settings.kind) ? heatmaps::heatmap_size(sensor, settings.rendering.factor) : sensor;
}

std::string input_text(ModelKind kind, events::SensorSize input) {
  return reads_heatmaps(kind) ? fmt::format("heatmaps of {} x {} cells", input.width, input.height)
                              : fmt::format("events of a sensor of {} x {} px", input.width, input.height);
}

std::vector<std::size_t> features_shape(ModelKind kind) {
  if (kind == ModelKind::stream) return {StreamLayout::places, StreamLayout::cells_of_place + 1};
  if (kind == ModelKind::temporal) return {features::steps_of_history, features::features_of_step};
  return {features::feature_count};
}

void check_history(const ModelSettings& settings) {
  const heatmaps::HeatmapOptions& rendering = settings.rendering;
  if (settings.kind == ModelKind::trees) features::bin_of(rendering.tick, rendering.history);
  if (settings.kind == ModelKind::temporal) features::step_windows(rendering.history, rendering.tick, rendering.tick);
}

std::vector<ParameterShape> parameters_of(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::lenet) return lenet_layers(input, settings.network).parameters();
  if (settings.kind == ModelKind::temporal) {
    check(settings.temporal);
    return temporal_parameters(settings.temporal);
  }
  if (settings.kind == ModelKind::stream) {
    check(settings.stream);
    return stream_parameters();
  }
  check(settings.trees);
  return tree_parameters(settings.trees);
}

nlohmann::json network_json(const ModelSettings& settings, events::SensorSize input) {
  if (settings.kind == ModelKind::lenet) return json_of(lenet_layers(input, settings.network), settings.network);
  std::size_t parameters = 0;
  for (const ParameterShape& shape : parameters_of(settings, input)) parameters += shape.count();
  const std::vector<std::size_t> shape = features_shape(settings.kind);
  nlohmann::json json = {{"name", network_name(settings.kind)},
                         {"input", {{"height", input.height}, {"width", input.width}, {"features", shape.back()}}},
                         {"parameters", parameters}};
  if (settings.kind == ModelKind::temporal) json["input"]["steps"] = shape.front();
  if (settings.kind == ModelKind::stream) json["input"]["places"] = shape.front();
  json.update(nlohmann::json(settings).at("network"));
  return json;
}

}  // namespace tactile::model
