#include "tactile/model/bundle/exported_network.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/model/bundle/onnx_model.hpp"
#include "tactile/model/bundle/onnx_stream.hpp"

namespace tactile::model {
namespace {

/// Of the dataset. Without one, the smallest sensor that gives heatmaps of this size.
events::SensorSize sensor_of(const ModelDescription& model) {
  if (model.settings.kind == ModelKind::stream) return model.input;
  if (const auto& manifest = model.manifest; manifest.contains("sensor")) {
    const auto sensor = manifest.at("sensor");
    return {member<int>(sensor, "width", "model.json"), member<int>(sensor, "height", "model.json")};
  }
  const int pixels = static_cast<int>(std::lround(1 / model.settings.rendering.factor));
  return {pixels * model.input.width, pixels * model.input.height};
}

}  // namespace

OwnDescription exported_description(const ModelDescription& model, const Weights& weights, double temperature) {
  const bool is_stream = model.settings.kind == ModelKind::stream;
  if (!is_stream && model.settings.kind != ModelKind::lenet)
    throw Error(fmt::format("a model of kind {} has no ONNX file; expected kind lenet or stream", name_of(model.settings.kind)));
  OwnDescription description;
  description.input = is_stream ? OwnInput::counts : OwnInput::heatmap;
  description.input_name = is_stream ? "counts" : "heatmaps";
  description.output_name = "logits";
  description.sensor = sensor_of(model);
  description.rendering = model.settings.rendering;
  description.temperature = temperature;
  for (const LearnedRun& run : model.learned_from) description.learned_from.push_back(run);
  if (!is_stream) return description;
  const std::vector<float>& grid = weights.front().values;
  std::copy_n(grid.begin(), description.grid.size(), description.grid.begin());
  description.states = stream_states();
  return description;
}

std::string exported_onnx(const ModelDescription& model, const Weights& weights, const std::string& name,
                          const std::map<std::string, std::string>& metadata) {
  if (model.settings.kind == ModelKind::stream) return onnx_stream(weights, name, metadata);
  return onnx_model(lenet_layers(model.input), model.settings.network, weights, name, metadata);
}

}  // namespace tactile::model
