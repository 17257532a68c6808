#include "tactile/model/bundle/own_description.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/definition/stream_options.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> input_names{"heatmap", "counts"};
constexpr int format = 1;
constexpr std::int64_t most_values = std::int64_t{16} << 20;  // of all states
constexpr std::size_t most_states = 64;

const char* usual_input_name(OwnInput input) { return input == OwnInput::heatmap ? "heatmaps" : "counts"; }

/// The member "name"; `usual` without it.
std::string name_in(const nlohmann::json& json, const std::string& usual, const std::string& where) {
  return json.contains("name") ? member<std::string>(json, "name", where) : usual;
}

/// The number of values; nothing if a size is below 1, or there are too many.
std::optional<std::int64_t> count_of(const std::vector<std::int64_t>& shape) {
  std::int64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 1 || size > most_values / count) return std::nullopt;
    count *= size;
  }
  return count;
}

std::vector<NetworkState> states_in(const nlohmann::json& json, const std::string& where) {
  std::vector<NetworkState> states;
  std::int64_t left = most_values;
  const auto listed = member<std::vector<nlohmann::json>>(json, "states", where);
  if (listed.size() > most_states)
    throw Error(fmt::format("{}: {} states; expected {} at most", where, listed.size(), most_states));
  for (const nlohmann::json& state : listed) {
    const std::string of_state = where + ": states";
    states.push_back({member<std::string>(state, "input", of_state), member<std::string>(state, "output", of_state),
                      member<std::vector<std::int64_t>>(state, "shape", of_state)});
    const NetworkState& added = states.back();
    const std::optional<std::int64_t> count = added.shape.size() > 8 ? std::nullopt : count_of(added.shape);
    if (!count || *count > left)
      throw Error(fmt::format("{}: {}: a shape of {}; expected sizes of 1 or more, and {} values at most in all states", of_state,
                              added.input, nlohmann::json(added.shape).dump(), most_values));
    left -= *count;
  }
  return states;
}

void read_input(const nlohmann::json& json, const std::string& where, OwnDescription& description) {
  const auto input = member<nlohmann::json>(json, "input", where);
  description.input = enumerator_named<OwnInput>(member<std::string>(input, "kind", where), input_names, where + ": input.kind");
  description.input_name = name_in(input, usual_input_name(description.input), where + ": input");
  const auto sensor = member<nlohmann::json>(json, "sensor", where);
  description.sensor = {member<int>(sensor, "width", where), member<int>(sensor, "height", where)};
  const auto [width, height] = description.sensor;
  if (std::min(width, height) < 1 || std::max(width, height) > events::most_side)
    throw Error(fmt::format("{}: a sensor of {} x {} px; expected sides of 1 to {}", where, width, height, events::most_side));
  try {
    description.rendering = member<nlohmann::json>(json, "rendering", "description").get<heatmaps::HeatmapOptions>();
    check(description.rendering);
  } catch (const Error& e) {
    throw Error(where + ": " + e.what());
  }
  const heatmaps::HeatmapOptions& rendering = description.rendering;
  if (description.input == OwnInput::counts) {
    description.grid = member<std::array<double, 4>>(json, "grid", where);
    if (rendering.history != rendering.tick)
      throw Error(fmt::format("{}: rendering: history_us of {}; expected {}, the tick, whose events are counted", where,
                              rendering.history.count(), rendering.tick.count()));
  }
  const auto shape = member<std::vector<std::int64_t>>(input, "shape", where);
  if (const auto expected = description.input_shape(); shape != expected)
    throw Error(fmt::format("{}: input.shape of {}; expected {}, which is what {} has at a tick", where,
                            nlohmann::json(shape).dump(), nlohmann::json(expected).dump(),
                            description.input == OwnInput::heatmap ? "a heatmap of this sensor" : "a count of each cell"));
}

}  // namespace

nlohmann::json class_names() {
  nlohmann::json names = nlohmann::json::array();
  for (const Touch touch : all_touches) names.push_back(name_of(touch));
  return names;
}

std::string_view name_of(OwnInput input) { return input_names.at(static_cast<std::size_t>(input)); }

std::vector<std::int64_t> OwnDescription::input_shape() const {
  if (input == OwnInput::counts) return {StreamLayout::places, StreamLayout::cells_of_place};
  const events::SensorSize size = heatmaps::heatmap_size(sensor, rendering.factor);
  return {1, 1, size.height, size.width};
}

void to_json(nlohmann::json& json, const OwnDescription& description) {
  nlohmann::json states = nlohmann::json::array();
  for (const NetworkState& state : description.states)
    states.push_back({{"input", state.input}, {"output", state.output}, {"shape", state.shape}});
  json = {
      {"format", format},
      {"input", {{"kind", name_of(description.input)}, {"name", description.input_name}, {"shape", description.input_shape()}}},
      {"output", {{"name", description.output_name}}},
      {"sensor", {{"width", description.sensor.width}, {"height", description.sensor.height}}},
      {"rendering", description.rendering},
      {"classes", class_names()},
      {"states", states},
      {"temperature", description.temperature},
      {"learned_from", description.learned_from}};
  if (description.input == OwnInput::counts) json["grid"] = description.grid;
}

OwnDescription own_description_in(const nlohmann::json& json, const std::string& where) {
  OwnDescription description;
  if (const int found = member<int>(json, "format", where); found != format)
    throw Error(fmt::format("{}: of format {}; expected {}", where, found, format));
  if (member<nlohmann::json>(json, "classes", where) != class_names())
    throw Error(where + ": its classes are not none, press and slip; expected these, in this order");
  read_input(json, where, description);
  description.output_name = name_in(json.value("output", nlohmann::json()), "logits", where + ": output");
  if (json.contains("states")) description.states = states_in(json, where);
  if (json.contains("temperature")) description.temperature = member<double>(json, "temperature", where);
  if (!(description.temperature > 0) || !std::isfinite(description.temperature))
    throw Error(fmt::format("{}: a temperature of {}; expected one above 0", where, description.temperature));
  description.learned_from = member<std::vector<nlohmann::json>>(json, "learned_from", where);
  return description;
}

bool is_own_network(const fs::path& file) {
  std::error_code unknown;
  return (file.extension() == ".pt" || file.extension() == ".onnx") && fs::is_regular_file(file, unknown);
}

fs::path own_description_file(const fs::path& network) { return fs::path(network).replace_extension(".json"); }

OwnDescription read_own_description(const fs::path& network) {
  const fs::path file = own_description_file(network);
  if (!fs::is_regular_file(file))
    throw Error(fmt::format("{}: has no description; expected {} beside it, which says what the network reads", network.string(),
                            file.filename().string()));
  return own_description_in(read_json(file), file.string());
}

}  // namespace tactile::model
