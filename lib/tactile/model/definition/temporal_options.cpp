#include "tactile/model/definition/temporal_options.hpp"

#include <fmt/core.h>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/features/step_features.hpp"

namespace tactile::model {

void to_json(nlohmann::json& json, const TemporalOptions& options) { json = {{"channels", options.channels}}; }

void from_json(const nlohmann::json& json, TemporalOptions& options) {
  options.channels = member<unsigned>(json, "channels", "settings of a temporal convolution");
}

void check(const TemporalOptions& options) {
  if (options.channels < 1 || options.channels > 64)
    throw Error(fmt::format("temporal convolution: {} channels; expected 1 to 64", options.channels));
}

std::vector<ParameterShape> temporal_parameters(const TemporalOptions& options) {
  const std::int64_t channels = options.channels, classes = touch_count;
  std::int64_t inputs = features::features_of_step;
  std::vector<ParameterShape> parameters{{"input.mean", {inputs}}, {"input.scale", {inputs}}};
  for (std::size_t layer = 1; layer <= temporal_layers; ++layer) {
    parameters.push_back({fmt::format("conv{}.weight", layer), {channels, inputs, 2}});
    parameters.push_back({fmt::format("conv{}.bias", layer), {channels}});
    inputs = channels;
  }
  parameters.push_back({"out.weight", {classes, channels}});
  parameters.push_back({"out.bias", {classes}});
  return parameters;
}

}  // namespace tactile::model
