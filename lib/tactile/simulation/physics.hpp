#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/session_camera.hpp"
#include "tactile/simulation/simulated_imu.hpp"
#include "tactile/simulation/simulated_robot.hpp"
#include "tactile/simulation/simulated_video.hpp"

namespace tactile::simulation {

/// A size of data set.
struct SimulationPreset {
  int runs = 0;  ///< per object
  RunTimings timings;
  bool special_runs = false;  ///< some runs are not a plain press and slip
};

/// Everything that simulated runs are drawn from, except the seed.
struct SimulationPhysics {
  std::string source = "default";  ///< the name of the file; not a setting
  EventCameraOptions camera;
  SessionPhysics sessions;
  RunVariation variation;
  AfterEffects after_effects;
  SpecialRuns special_runs;
  RobotPhysics robot;
  VideoPhysics video;
  ImuPhysics imu;
  ClockPhysics clocks;
  std::map<std::string, SimulationPreset> presets{{"paper", {}}, {"quick", {}}, {"tiny", {}}};
  std::vector<ObjectModel> objects;  ///< the paper's ten objects, in its order, and those that a file adds

  // Each throws Error for an unknown name, with the nearest name and a list.
  const ObjectModel& object(std::string_view name) const;
  std::size_t place_of(std::string_view object) const;  ///< in `objects`
  const SimulationPreset& preset(std::string_view name) const;

  /// The options of a run's plan. @param run_number  from 1
  RunPlanOptions plan_options(const SimulationPreset& preset, int run_number) const;
};

/// configs/simulation.json, configs/cameras.json and configs/objects.json, as of the build.
const SimulationPhysics& default_physics();

/// The defaults with another camera of configs/cameras.json. @throws Error  for an unknown name
SimulationPhysics with_camera(std::string_view preset);

/// The defaults, changed by the file: any member of configs/simulation.json, and `objects`, a list as in configs/objects.json.
/// Its entries change the object of the same name member by member, or add an object. `camera.preset` names a camera of
/// configs/cameras.json, and the other members of `camera` change it. `why` may describe the file's purpose.
/// @param camera_preset  instead of the file's, unless empty
/// @throws Error  with the file and the member, and the nearest known name or the allowed range
SimulationPhysics read_physics(const std::filesystem::path& file, std::string_view camera_preset = {});

/// The same from JSON. @param where  names it in errors
SimulationPhysics physics_from(const nlohmann::json& json, const std::string& where);

nlohmann::json json_of(const SimulationPhysics& physics);  ///< complete: `physics_from` gives the same physics

template <class Fields>
void list_fields(Fields& fields, SimulationPreset& preset) {
  fields("runs", preset.runs, 1, 99);
  fields("timings", preset.timings);
  fields("special_runs", preset.special_runs);
}

/// All settings except the objects, which are a list.
template <class Fields>
void list_fields(Fields& fields, SimulationPhysics& physics) {
  fields("camera", physics.camera);
  fields("sessions", physics.sessions);
  fields("variation", physics.variation);
  fields("after_effects", physics.after_effects);
  fields("special_runs", physics.special_runs);
  fields("robot", physics.robot);
  fields("video", physics.video);
  fields("imu", physics.imu);
  fields("clocks", physics.clocks);
  fields("presets", physics.presets);
}

}  // namespace tactile::simulation
