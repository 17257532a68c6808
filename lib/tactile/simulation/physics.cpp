#include "tactile/simulation/physics.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/fields.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/simulation/default_configs.hpp"

namespace tactile::simulation {
namespace {

[[noreturn]] void refuse_name(std::string_view name, std::string_view what, const std::vector<std::string>& names) {
  std::string listed;
  for (const std::string& known : names) listed += (listed.empty() ? "" : ", ") + known;
  const std::string nearest = nearest_name(name, names);
  throw Error(nearest.empty() ? fmt::format("'{}' is no {}; expected one of {}", name, what, listed)
                              : fmt::format("'{}' is no {}; the nearest is '{}', of {}", name, what, nearest, listed));
}

std::vector<std::string> names_of(const std::vector<ObjectModel>& objects) {
  std::vector<std::string> names;
  names.reserve(objects.size());
  for (const ObjectModel& object : objects) names.push_back(object.name);
  return names;
}

/// Changes the objects of the same name member by member, and appends new ones.
void read_objects(const nlohmann::json& json, std::vector<ObjectModel>& objects, const std::string& where) {
  if (!json.is_array()) throw Error(where + ": objects is not a list; expected a list of objects");
  std::vector<std::string> seen;
  for (const nlohmann::json& entry : json) {
    const auto name = member<std::string>(entry, "name", where + ": an object in objects");
    if (!is_object_name(name))
      throw Error(fmt::format("{}: objects has a '{}'; expected a name of lower-case letters, digits and hyphens", where, name));
    if (std::find(seen.begin(), seen.end(), name) != seen.end())
      throw Error(fmt::format("{}: objects has '{}' twice; expected each once", where, name));
    seen.push_back(name);
    auto object = std::find_if(objects.begin(), objects.end(), [&](const ObjectModel& known) { return known.name == name; });
    if (object == objects.end()) object = objects.insert(objects.end(), ObjectModel{});
    FieldReader members(entry, where, fmt::format("objects.{}.", name));
    list_fields(members, *object);
    members.refuse_others();
  }
}

/// The cameras of configs/cameras.json by name. @throws Error  if it is none of them
EventCameraOptions preset_camera(std::string_view name) {
  static const std::map<std::string, EventCameraOptions> cameras = [] {
    const std::string where = "configs/cameras.json";
    std::map<std::string, EventCameraOptions> read;
    const nlohmann::json json = nlohmann::json::parse(default_cameras_config());
    for (const auto& [preset, members] : json.items()) {
      read_fields(members, read[preset], where);
      read[preset].preset = preset;
    }
    return read;
  }();
  const auto found = cameras.find(std::string(name));
  if (found != cameras.end()) return found->second;
  std::vector<std::string> names;
  names.reserve(cameras.size());
  for (const auto& [known, camera] : cameras) names.push_back(known);
  refuse_name(name, "preset of the camera", names);
}

void read_into(SimulationPhysics& physics, const nlohmann::json& json, const std::string& where) {
  if (json.is_object() && json.contains("camera") && json["camera"].is_object() && json["camera"].contains("preset")) {
    try {
      physics.camera = preset_camera(member<std::string>(json["camera"], "preset", "camera"));
    } catch (const Error& e) {
      throw Error(where + ": " + e.what());
    }
  }
  FieldReader members(json, where, {});
  std::string why;
  members("why", why);
  const nlohmann::json* objects = members.find("objects");
  list_fields(members, physics);
  members.refuse_others();
  if (objects != nullptr) read_objects(*objects, physics.objects, where);
  const SpecialRuns& special = physics.special_runs;
  const double shares = special.two_presses + special.without_slip + special.without_press + special.firm_lifts;
  if (shares > 1.0 + 1e-9) {
    throw Error(
        fmt::format("{}: special_runs.two_presses, without_slip, without_press and firm_lifts add up to {:g}; expected at most 1",
                    where, shares));
  }
  try {
    check(physics.camera);
  } catch (const Error& e) {
    throw Error(where + ": " + e.what());
  }
}

SimulationPhysics read_default_physics() {
  SimulationPhysics physics;
  read_into(physics, nlohmann::json::parse(default_simulation_config()), "configs/simulation.json");
  read_objects(nlohmann::json::parse(default_objects_config()), physics.objects, "configs/objects.json");
  return physics;
}

}  // namespace

const ObjectModel& SimulationPhysics::object(std::string_view name) const { return objects[place_of(name)]; }

std::size_t SimulationPhysics::place_of(std::string_view name) const {
  const auto found = std::find_if(objects.begin(), objects.end(), [&](const ObjectModel& known) { return known.name == name; });
  if (found == objects.end()) refuse_name(name, "object that can be simulated", names_of(objects));
  return static_cast<std::size_t>(found - objects.begin());
}

const SimulationPreset& SimulationPhysics::preset(std::string_view name) const {
  const auto found = presets.find(std::string(name));
  if (found != presets.end()) return found->second;
  std::vector<std::string> names;
  names.reserve(presets.size());
  for (const auto& [known, preset] : presets) names.push_back(known);
  refuse_name(name, "preset of the simulation", names);
}

RunPlanOptions SimulationPhysics::plan_options(const SimulationPreset& preset, int run_number) const {
  return {.timings = preset.timings,
          .variation = variation,
          .after = after_effects,
          .special = special_runs,
          .imu_share = imu.share,
          .run_number = run_number,
          .may_be_special = preset.special_runs};
}

const SimulationPhysics& default_physics() {
  static const SimulationPhysics physics = read_default_physics();
  return physics;
}

SimulationPhysics with_camera(std::string_view preset) { return physics_from({{"camera", {{"preset", preset}}}}, "--camera"); }

SimulationPhysics read_physics(const std::filesystem::path& file, std::string_view camera_preset) {
  nlohmann::json json = read_json(file);
  if (!camera_preset.empty() && json.is_object() && (!json.contains("camera") || json["camera"].is_object()))
    json["camera"]["preset"] = camera_preset;
  SimulationPhysics physics = physics_from(json, file.string());
  physics.source = file.filename().string();
  return physics;
}

SimulationPhysics physics_from(const nlohmann::json& json, const std::string& where) {
  SimulationPhysics physics = default_physics();
  read_into(physics, json, where);
  return physics;
}

nlohmann::json json_of(const SimulationPhysics& physics) {
  nlohmann::json json = json_of_fields(physics);
  json["objects"] = nlohmann::json::array();
  for (const ObjectModel& object : physics.objects) json["objects"].push_back(json_of_fields(object));
  return json;
}

}  // namespace tactile::simulation
