#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::model {

/// ["none", "press", "slip"], the order of the logits.
nlohmann::json class_names();

/// What a network of one's own reads at a tick.
enum class OwnInput : std::uint8_t {
  heatmap,  ///< [1, 1, height, width], a heatmap / 255, in [0, 1]
  counts,   ///< [9, 144], the events of the tick by place and cell, as `StreamLayout` orders them
};

std::string_view name_of(OwnInput input);  ///< "heatmap", "counts"

/// An input that a network is given back at the next tick: the values that its output had. At the start all are 0.
struct NetworkState {
  std::string input, output;
  std::vector<std::int64_t> shape;

  friend bool operator==(const NetworkState&, const NetworkState&) = default;
};

/// What a network that another program trained reads and gives: NAME.json beside NAME.pt or NAME.onnx.
struct OwnDescription {
  OwnInput input = OwnInput::heatmap;
  std::string input_name, output_name;                    ///< of the network's input, and of its logits
  events::SensorSize sensor;                              ///< [px]
  heatmaps::HeatmapOptions rendering;                     ///< of counts, history, tick and mask: the history is the tick
  std::array<double, 4> grid{};                           ///< of counts: left, top, right, bottom of what the cells divide [px]
  std::vector<NetworkState> states;                       ///< none: the logits of a tick depend on its input alone
  double temperature = 1;                                 ///< of the probabilities, above 0
  nlohmann::json learned_from = nlohmann::json::array();  ///< of its training runs, as a bundle's model.json has them

  /// The shape of the network's input.
  std::vector<std::int64_t> input_shape() const;
};

/// {"format", "input": {"kind", "name", "shape"}, "output": {"name"}, "sensor": {"width", "height"}, "rendering", "grid" of
/// counts, "classes", "states": [{"input", "output", "shape"}], "temperature", "learned_from"}
void to_json(nlohmann::json& json, const OwnDescription& description);

/// Reads it. "states", "temperature" and the names of input and output may be left out: then they are none, 1, "heatmaps" or
/// "counts", and "logits".
/// @param where   the file, for errors
/// @throws Error  if a member is missing or wrong: other classes, a shape that differs from what a tick gives, states of more
/// than
///                16 Mi values; nothing of that size is allocated
OwnDescription own_description_in(const nlohmann::json& json, const std::string& where);

/// Whether this is a network's file, by its ending: .pt (TorchScript) or .onnx.
bool is_own_network(const std::filesystem::path& file);

/// NAME.json.
std::filesystem::path own_description_file(const std::filesystem::path& network);

/// @throws Error  if there is no description, or as `own_description_in`
OwnDescription read_own_description(const std::filesystem::path& network);

}  // namespace tactile::model
