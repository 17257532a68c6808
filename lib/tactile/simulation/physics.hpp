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
#include "tactile/simulation/simulated_imu.hpp"
#include "tactile/simulation/simulated_robot.hpp"
#include "tactile/simulation/simulated_video.hpp"

namespace tactile {

/// A size of data set.
struct SimulationPreset {
  int runs = 0;  ///< per object
  RunTimings timings;
  bool special_runs = false;  ///< has runs that are no plain press and slip
};

/// All that simulated runs are drawn from, but the seed.
struct SimulationPhysics {
  std::string source = "default";  ///< the name of the file that it was read from; no setting of its own
  EventCameraOptions camera;
  RunVariation variation;
  AfterEffects after_effects;
  SpecialRuns special_runs;
  RobotPhysics robot;
  VideoPhysics video;
  ImuPhysics imu;
  ClockPhysics clocks;
  std::map<std::string, SimulationPreset> presets{{"paper", {}}, {"quick", {}}, {"tiny", {}}};
  std::vector<ObjectModel> objects;  ///< the paper's ten, in its order, and any that a file adds

  // Each throws Error that names the nearest, and lists them, if there is none of this name.
  const ObjectModel& object(std::string_view name) const;
  std::size_t place_of(std::string_view object) const;  ///< in `objects`
  const SimulationPreset& preset(std::string_view name) const;

  /// What the plan of a run is drawn from. @param run_number  from 1
  RunPlanOptions plan_options(const SimulationPreset& preset, int run_number) const;
};

/// configs/simulation.json and configs/objects.json, as they were when this was built.
const SimulationPhysics& default_physics();

/// The defaults, with what the file gives in their place: any member of configs/simulation.json, and `objects`, a list like that
/// of configs/objects.json whose members replace those of the same name, member by member, or are added. `why` may say in a
/// sentence what the file is for.
/// @throws Error  naming the file and the member, with the nearest name where there is none of it, or the range it must lie in
SimulationPhysics read_physics(const std::filesystem::path& file);

/// Likewise, from JSON that `where` names. @throws Error likewise
SimulationPhysics physics_from(const nlohmann::json& json, const std::string& where);

nlohmann::json json_of(const SimulationPhysics& physics);  ///< whole; `physics_from` of it gives the same

template <class Fields>
void list_fields(Fields& fields, SimulationPreset& preset) {
  fields("runs", preset.runs, 1, 99);
  fields("timings", preset.timings);
  fields("special_runs", preset.special_runs);
}

/// All but the objects, which are a list.
template <class Fields>
void list_fields(Fields& fields, SimulationPhysics& physics) {
  fields("camera", physics.camera);
  fields("variation", physics.variation);
  fields("after_effects", physics.after_effects);
  fields("special_runs", physics.special_runs);
  fields("robot", physics.robot);
  fields("video", physics.video);
  fields("imu", physics.imu);
  fields("clocks", physics.clocks);
  fields("presets", physics.presets);
}

}  // namespace tactile
