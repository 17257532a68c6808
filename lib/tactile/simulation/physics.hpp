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
  EventCameraOptions camera;
  RunVariation variation;
  AfterEffects after_effects;
  SpecialRuns special_runs;
  RobotPhysics robot;
  VideoPhysics video;
  ImuPhysics imu;
  ClockPhysics clocks;
  std::map<std::string, SimulationPreset> presets;  ///< "paper", "quick", "tiny"
  std::vector<ObjectModel> objects;                 ///< the paper's ten, in its order, and any that a file adds

  const ObjectModel& object(std::string_view name) const;         ///< @throws Error that lists them if none has this name
  const SimulationPreset& preset(std::string_view name) const;    ///< @throws Error likewise
  double longest_run_s(const SimulationPreset& preset) const;     ///< an upper bound
};

/// configs/simulation.json and configs/objects.json, as they were when this was built.
const SimulationPhysics& default_physics();

/// The defaults, with what the file gives in their place: any member of configs/simulation.json, and `objects`, a list like that of
/// configs/objects.json whose members replace those of the same name, member by member, or are added.
/// @throws Error  naming the file and the member, with the nearest name where there is none of it, or the range it must lie in
SimulationPhysics read_physics(const std::filesystem::path& file);

nlohmann::json json_of(const SimulationPhysics& physics);  ///< whole; `read_physics` of it gives the same

}  // namespace tactile
