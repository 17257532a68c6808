#include "tactile/experiments/stress/simulated_worlds.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/fields.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/simulation/simulate.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<double, 2> nearer{50, 100};
constexpr std::array<double, 4> dim{50, 75, 90, 97};
constexpr std::array<double, 4> flicker{2, 5, 10, 30};
constexpr std::array<double, 3> faster{50, 100, 200};
constexpr std::array<double, 3> slower{50, 75, 90};
constexpr std::array<double, 3> shaken{2, 9, 29};

constexpr std::array<SimulatedWorld, 6> worlds{{
    {"camera-noisy", "% of the difference to the camera 'noisy'", nearer, 200,
     "A camera with more noise, more hot pixels, slower pixels and a slower read-out."},
    {"light-dim", "% of the light lost", dim, 99,
     "Less light: pixels react more slowly, and contrasts drown in the dark current."},
    {"light-flicker", "% depth at 100 Hz", flicker, 99, "A lamp on the mains: the light of all pixels flickers."},
    {"motion-fast", "% faster", faster, 400, "Presses and lifts are faster than in the training runs."},
    {"motion-slow", "% slower", slower, 95, "Presses and lifts are slower than in the training runs."},
    {"motion-ringing", "times more ringing", shaken, 99, "The arm rings more when it starts and stops."},
}};

void scale(json& value, double factor) {
  if (value.is_array()) {
    for (json& each : value) scale(each, factor);
  } else if (value.is_number()) {
    value = value.get<double>() * factor;
  }
}

/// Moves the numbers of a camera towards those of another; with a share of 1 it is the other.
void move_towards(json& camera, const json& other, double share) {
  for (auto& [name, value] : camera.items()) {
    if (!value.is_number() || share == 1) {
      if (share >= 1) value = other.at(name);
      continue;
    }
    const double moved = std::max(0.0, std::lerp(value.get<double>(), other.at(name).get<double>(), share));
    value = value.is_number_integer() ? json(std::llround(moved)) : json(moved);
  }
}

void change(json& physics, std::string_view world, double severity) {
  json &camera = physics["camera"], &variation = physics["variation"];
  if (world == "camera-noisy") {
    move_towards(camera, json_of_fields(simulation::with_camera("noisy").camera), severity / 100);
  } else if (world == "light-dim") {
    for (const char* name : {"skin", "black", "white"}) scale(camera[name], 1 - severity / 100);
    for (const char* name : {"veil", "object_veil"}) scale(variation[name], 1 - severity / 100);
  } else if (world == "light-flicker") {
    camera["flicker_depth"] = severity / 100;
    camera["flicker_hz"] = 100;
  } else if (world == "motion-fast" || world == "motion-slow") {
    const double factor = world == "motion-fast" ? 1 + severity / 100 : 1 - severity / 100;
    for (const char* name : {"lift_speed_mm_s", "closing_speed_mm_s"}) scale(variation[name], factor);
    scale(variation["press_s"], 1 / factor);
  } else {
    scale(physics["after_effects"]["vibration_mm"], 1 + severity);
  }
}

const SimulatedWorld& world_named(const std::string& name) {
  const auto found = std::find_if(worlds.begin(), worlds.end(), [&](const SimulatedWorld& world) { return world.name == name; });
  if (found != worlds.end()) return *found;
  std::vector<std::string> names;
  std::string list;
  for (const SimulatedWorld& world : worlds) {
    names.emplace_back(world.name);
    list += (list.empty() ? "" : ", ") + names.back();
  }
  const std::string nearest = nearest_name(name, names);
  throw Error(
      fmt::format("'{}' is no simulated world; {}", name,
                  nearest.empty() ? "expected one of " + list : fmt::format("the nearest is '{}', of {}", nearest, list)));
}

}  // namespace

std::span<const SimulatedWorld> world_list() { return worlds; }

StressSeries world_series_in(const std::string& text) {
  const SeverityList given = severities_in(text);
  const SimulatedWorld& world = world_named(given.name);
  if (!given.parameters.empty())
    throw Error(fmt::format("'{}': a world takes no parameters; expected {}:SEVERITY,...", text, given.name));
  StressSeries series{.name = given.name,
                      .unit = std::string(world.unit),
                      .meaning = std::string(world.text),
                      .severities = given.severities,
                      .world = given.name,
                      .recipes = {}};
  if (series.severities.empty()) series.severities.assign(world.usual.begin(), world.usual.end());
  if (series.severities.back() > world.most) {
    throw Error(fmt::format("'{}': a severity of {:g} {}; expected at most {:g}", text, series.severities.back(), world.unit,
                            world.most));
  }
  return series;
}

simulation::SimulationPhysics physics_in(std::string_view world, double severity, const simulation::SimulationPhysics& own) {
  json changed = simulation::json_of(own);
  change(changed, world, severity);
  simulation::SimulationPhysics physics = simulation::physics_from(changed, fmt::format("the world {}:{:g}", world, severity));
  physics.source = fmt::format("{}:{:g}", world, severity);
  return physics;
}

RunFolder simulated_in_world(const RunFolder& run, std::string_view world, double severity, const fs::path& cache) {
  const simulation::RunSettings own = simulation::read_run_settings(run);
  const simulation::SimulationPhysics physics = physics_in(world, severity, own.physics);
  const std::string hash = hash_of(simulation::simulation_settings(physics, own.object, own.run, own.preset, own.seed));
  RunFolder target{
      cache / fmt::format("{}-{:g}", world, severity) / fmt::format("{}-{}-{}", run.object, run.run, hash.substr(0, 8)),
      run.object, run.run};
  if (fs::exists(target.truth())) return target;
  WholeFile whole(target.folder, IfThere::replace);
  fs::create_directory(whole.path());
  const simulation::DrawnRun drawn = simulation::draw_run(physics, own.object, own.run, own.preset, own.seed);
  simulation::simulate_events({whole.path(), run.object, run.run}, drawn, simulation::camera_pixels_of(drawn));
  if (!fs::exists(target.truth())) whole.commit();  // another task may have simulated it meanwhile
  return target;
}

}  // namespace tactile::stress
