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
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::study {

/// What to study, and how.
struct StudyOptions {
  std::filesystem::path data = "data", models = "models", out = "study";
  std::string preset = "quick";  ///< "tiny", "quick", "paper": of the simulation, and see `preset_settings`

  // Of the simulation, if `data` holds no runs.
  std::vector<std::string> objects = {};  ///< all objects if empty
  std::optional<int> runs = {};           ///< per object; the preset's if not given
  bool force = false;                     ///< replace runs that were simulated with other settings

  bool include_flagged = false;  ///< also use flagged runs and intervals
  bool strict = false;           ///< an object without samples is an error

  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};  ///< t_h, each a whole number of ticks
  std::string train_run = "01";
  std::vector<std::string> held_out;       ///< empty: those of `default_held_out` that the dataset has
  bool hold_out_each = false;              ///< instead: each object alone
  std::optional<unsigned> epochs = {};     ///< the preset's if not given
  std::optional<unsigned> trainings = {};  ///< of each setting, each on another run and seed, > 0; the preset's if not given
  std::uint64_t seed = 1;  ///< of simulation, samples, drawn splits and the first training; the next ones add 1, 2, …
  std::optional<std::size_t> splits = {};  ///< drawn from all ways to hold out as many objects; the preset's if not given

  model::EngineKind engine = model::EngineKind::fast;  ///< runs the models
  std::filesystem::path program = "/proc/self/exe";    ///< trains
  std::optional<experiments::SlurmOptions> slurm{};    ///< trainings run on a cluster; nothing: on this machine
  unsigned threads = 0;                                ///< 0: as many as the machine has cores
};

/// What a preset decides besides the simulation.
struct PresetSettings {
  std::size_t choice_runs;  ///< number of runs of each object to choose a history on: those after the training run
  unsigned epochs;
  unsigned trainings;
  std::size_t splits;
};

/// @throws Error  if there is no such preset
PresetSettings preset_settings(std::string_view preset);

/// The same options with the preset's values and threads filled in, and histories ascending, each once.
/// @throws Error  if there is no such preset, no history or no training, or a history is out of its range
StudyOptions completed(StudyOptions options);

/// Receives a sentence about something that a user may not expect. May be empty.
using WarningCallback = std::function<void(const std::string& sentence)>;

inline constexpr microseconds default_history{40'000};  ///< the paper's, used if there are no runs to choose one on

}  // namespace tactile::study
