#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/physics.hpp"
#include "tactile/simulation/simulated_run.hpp"

namespace tactile::simulation {

struct SimulateOptions {
  std::filesystem::path data = "data";
  std::string preset = "quick";
  std::optional<int> runs = {};           ///< per object, 1 to 99; default: the preset's
  std::vector<std::string> objects = {};  ///< empty: all
  std::uint64_t seed = 1;                 ///< of the whole data set
  bool force = false;                     ///< replace simulated runs with other settings, and remove extra ones
  unsigned threads = 0;                   ///< 0: one per core
  SimulationPhysics physics = default_physics();
};

/// The outcome for one run.
struct SimulatedRun {
  enum class Kind { made, kept, replaced, removed };
  RunFolder run;
  Kind kind = Kind::made;
  std::uint64_t events = 0;  ///< of a run made or replaced in this call
  double duration_s = 0;
  std::uint64_t bytes = 0;         ///< of all its files
  std::uint64_t touch_events = 0;  ///< of such a run, in presses and slips
  double touch_s = 0;              ///< total duration of these presses and slips
};

/// Makes run folders. Each appears only when it is complete. The same seed gives the same bytes on any number of threads. A
/// simulated run with the same settings is kept. One with other settings is refused, or replaced with `force`, which also removes
/// further simulated runs of the same objects. Folders that were not simulated are never changed; in the place of a run they are
/// refused. One call at a time writes to a data folder.
/// @return  the outcomes, in order of object, then run
/// @throws Error  before anything is written, if an option or a folder is refused, or another call or process writes to `data`
std::vector<SimulatedRun> simulate(const SimulateOptions& options, const ProgressCallback& progress = {});

/// Makes only events.aedat4 and truth.json of one run, in its folder, which must exist and be empty.
/// @param pixels  those of `camera_pixels_of(drawn)`
void simulate_events(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels);

/// The settings that a simulated run was drawn from, as its truth.json has them.
struct RunSettings {
  SimulationPhysics physics;
  std::string object, run, preset;
  std::uint64_t seed = 1;
};

/// @throws Error  if the run was not simulated, or by another version, whose settings give other runs now
RunSettings read_run_settings(const RunFolder& run);

/// Makes the files of one run in its folder, which must exist and be empty.
/// @param pixels  those of `camera_pixels_of(drawn)`
SimulatedRun simulate_run(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels,
                          const std::function<void(double)>& report_share = {});

}  // namespace tactile::simulation
