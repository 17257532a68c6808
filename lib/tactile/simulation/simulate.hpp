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

namespace tactile {

struct SimulateOptions {
  std::filesystem::path data = "data";
  std::string preset = "quick";
  std::optional<int> runs = {};           ///< per object, 1 to 99; the preset's where it is not given
  std::vector<std::string> objects = {};  ///< all that there are where it is empty
  std::uint64_t seed = 1;                 ///< of the whole data set: one camera serves all of its runs
  bool force = false;                     ///< replace runs that this made with other settings, and remove its extra ones
  unsigned threads = 0;                   ///< 0: as many as the machine has cores
  SimulationPhysics physics = default_physics();
};

/// What became of one run.
struct SimulatedRun {
  enum class Kind { made, kept, replaced, removed };
  RunFolder run;
  Kind kind = Kind::made;
  std::uint64_t events = 0;  ///< of a run made or replaced now
  double duration_s = 0;
  std::uint64_t bytes = 0;         ///< of all its files
  std::uint64_t touch_events = 0;  ///< of a run made or replaced now: in presses and slips
  double touch_s = 0;              ///< which last so long
};

/// Makes run folders, each whole or not at all, and the same bytes for the same seed on any number of threads. A run that this
/// made with the same settings is kept as it is; one made with others is refused, or replaced with `force`, which also removes
/// runs of the same objects that this made beyond the number asked for. Any other folder is left alone, and refused where a run
/// is to stand.
/// @return what was done, in order of object, then run
/// @throws Error  before anything is written if an option or a folder is refused
std::vector<SimulatedRun> simulate(const SimulateOptions& options, const ProgressCallback& progress = {});

/// Makes one run's files in the folder, which is there and empty.
/// @param pixels  of the camera that serves all runs of the data set
SimulatedRun simulate_run(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels,
                          const std::function<void(double)>& tell_share = {});

}  // namespace tactile
