#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/experiments/stress/stress_series.hpp"
#include "tactile/simulation/physics.hpp"

namespace tactile::stress {

/// Another world for simulated runs: another camera, other light, motions outside the range of the training runs.
struct SimulatedWorld {
  std::string_view name;          ///< "camera-noisy"
  std::string_view unit;          ///< of the severity
  std::span<const double> usual;  ///< severities, ascending, > 0; at 0 the physics stay
  double most = 0;                ///< largest severity allowed
  std::string_view text;          ///< one sentence
};

std::span<const SimulatedWorld> world_list();

/// The series of what `--world` takes: "light-dim", "light-dim:50,90". @throws Error  for an unknown name or a severity out of
/// range
StressSeries world_series_in(const std::string& text);

/// The physics of a world. @param own  the physics of the run   @throws Error  as `simulation::physics_from`
simulation::SimulationPhysics physics_in(std::string_view world, double severity, const simulation::SimulationPhysics& own);

/// Simulates a run again in another world: the same object, run and seed, so that only what the world changes differs. Writes
/// events and truth to a folder of its own in `cache`, unless they are there already.
/// @return  the run there
/// @throws Error  if `run` was not simulated, or by another version
RunFolder simulated_in_world(const RunFolder& run, std::string_view world, double severity, const std::filesystem::path& cache);

}  // namespace tactile::stress
