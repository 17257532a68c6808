#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/experiments/slurm.hpp"
#include "tactile/model/definition/engine_kind.hpp"

namespace tactile::study {

/// What to study, and how.
struct StudyOptions {
  std::filesystem::path data = "data", models = "models", out = "study";
  std::string preset = "quick";  ///< "tiny", "quick", "paper": of the simulation, and see `preset_settings`

  // Of the simulation, if `data` holds no runs.
  std::optional<unsigned> worlds = {};    ///< > 0; the preset's if not given. Several have a folder each in `data`
  std::vector<std::string> objects = {};  ///< all objects if empty
  std::optional<int> runs = {};           ///< per object; the preset's if not given
  bool force = false;                     ///< replace runs that were simulated with other settings

  bool include_flagged = false;  ///< also use flagged runs and intervals
  bool strict = false;           ///< an object without samples is an error

  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};  ///< t_h, each a whole number of ticks
  std::string train_run = "01";
  std::vector<std::string> held_out = {};           ///< empty: those of `default_held_out`, in every second world the others
  std::optional<unsigned> epochs = {}, steps = {};  ///< of a LeNet, of a stream; the preset's if not given
  std::optional<unsigned> trainings = {};  ///< of each setting and world, on another run each, > 0; the preset's if not given
  std::uint64_t seed = 1;                  ///< of the first world and its first training; the next ones add 1, 2, …

  model::EngineKind engine = model::EngineKind::fast;  ///< runs the models
  std::filesystem::path program = "/proc/self/exe";    ///< trains
  std::optional<experiments::SlurmOptions> slurm{};    ///< trainings run on a cluster; nothing: on this machine
  unsigned threads = 0;                                ///< 0: as many as the machine has cores
};

/// What a preset decides besides the simulation.
struct PresetSettings {
  unsigned worlds;
  unsigned trainings, trainings_of_own_runs;  ///< of each setting: in a simulated world, and on runs that are there
  unsigned epochs, steps;
};

/// @throws Error  if there is no such preset
PresetSettings preset_settings(std::string_view preset);

/// Runs that share their objects and their sensor.
struct World {
  std::string name;  ///< "501", its seed, where the study has several; else empty
  std::uint64_t seed = 1;
  std::filesystem::path data;

  std::string suffix() const { return name.empty() ? "" : "-" + name; }  ///< of its steps' names
};

/// The same options with the preset's values and threads filled in, and histories ascending, each once.
/// @param has_own_runs  `data` holds runs that the study does not simulate: they are its only world
/// @throws Error  if there is no such preset, no history, world or training, a history is out of its range, or worlds are
///                requested of runs that are there
StudyOptions completed(StudyOptions options, bool has_own_runs);

/// @param options  as `completed` returns them
std::vector<World> worlds_of(const StudyOptions& options);

/// The history of the LeNet that is judged on whole runs: the trained one that is nearest to the paper's 40 ms.
microseconds main_history(const StudyOptions& options);

/// Receives a sentence about something that a user may not expect. May be empty.
using WarningCallback = std::function<void(const std::string& sentence)>;

}  // namespace tactile::study
