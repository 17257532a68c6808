#include "tactile/model/definition/lenet_layers.hpp"

#include "tactile/core/error.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::model {
namespace {

constexpr int kernel = 5, smallest_side = 16, largest_side = 4096;

events::SensorSize pooled(events::SensorSize size) { return {(size.width - kernel + 1) / 2, (size.height - kernel + 1) / 2}; }

}  // namespace

bool LeNetOptions::is_fast() const { return activation == Activation::relu && pooling == Pooling::max; }

std::size_t ParameterShape::count() const {
  std::size_t product = 1;
  for (const std::int64_t size : sizes) product *= static_cast<std::size_t>(size);
  return product;
}

std::vector<ParameterShape> LeNetLayers::parameters() const {
  const auto sizes = [](auto... values) { return std::vector<std::int64_t>{static_cast<std::int64_t>(values)...}; };
  return {{"conv1.weight", sizes(first_channels, 1, kernel, kernel)},
          {"conv1.bias", sizes(first_channels)},
          {"conv2.weight", sizes(second_channels, first_channels, kernel, kernel)},
          {"conv2.bias", sizes(second_channels)},
          {"fc1.weight", sizes(first_hidden, flat)},
          {"fc1.bias", sizes(first_hidden)},
          {"fc2.weight", sizes(second_hidden, first_hidden)},
          {"fc2.bias", sizes(second_hidden)},
          {"fc3.weight", sizes(touch_count, second_hidden)},
          {"fc3.bias", sizes(touch_count)}};
}

std::size_t LeNetLayers::parameter_count() const {
  std::size_t sum = 0;
  for (const ParameterShape& parameter : parameters()) sum += parameter.count();
  return sum;
}

LeNetLayers lenet_layers(events::SensorSize input) {
  if (input.width < smallest_side || input.height < smallest_side || input.width > largest_side || input.height > largest_side) {
    throw Error("heatmaps of " + std::to_string(input.width) + " x " + std::to_string(input.height) +
                " cells: the network's layers do not fit; expected " + std::to_string(smallest_side) + " to " +
                std::to_string(largest_side) + " a side");
  }
  LeNetLayers layers;
  layers.input = input;
  layers.first_pooled = pooled(input);
  layers.second_pooled = pooled(layers.first_pooled);
  layers.flat = LeNetLayers::second_channels * static_cast<std::size_t>(layers.second_pooled.width) *
                static_cast<std::size_t>(layers.second_pooled.height);
  return layers;
}

std::size_t heatmap_count(std::span<const std::uint8_t> heatmaps, events::SensorSize size) {
  const std::size_t cells = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  if (heatmaps.size() % cells == 0) return heatmaps.size() / cells;
  throw Error("heatmaps: " + std::to_string(heatmaps.size()) + " bytes; expected a whole number of heatmaps of " +
              std::to_string(size.width) + " x " + std::to_string(size.height) + " cells");
}

nlohmann::json json_of(const LeNetLayers& layers, const LeNetOptions& options) {
  const std::string activation(name_of(options.activation)), pool(name_of(options.pooling));
  const auto convolution = [](std::size_t channels) { return "conv " + std::to_string(channels) + "@5x5"; };
  const auto linear = [](std::size_t units) { return "linear " + std::to_string(units); };
  nlohmann::json json = {{"name", "lenet-5"},
                         {"input", {{"channels", 1}, {"height", layers.input.height}, {"width", layers.input.width}}},
                         {"layers",
                          {convolution(layers.first_channels), activation, pool + "-pool 2", convolution(layers.second_channels),
                           activation, pool + "-pool 2", "flatten " + std::to_string(layers.flat), linear(layers.first_hidden),
                           activation, linear(layers.second_hidden), activation, linear(touch_count)}},
                         {"parameters", layers.parameter_count()}};
  json.update(json_of_fields(options));
  return json;
}

}  // namespace tactile::model
