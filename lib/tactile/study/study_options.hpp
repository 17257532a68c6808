#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/windows/split.hpp"

namespace tactile {

/// What a study is asked for.
struct StudyOptions {
  std::filesystem::path data = "data", models = "models", out = "study";
  std::string preset = "quick";  ///< "tiny", "quick", "paper": of the simulation, and what `preset_settings` says

  // Of the simulation, where `data` holds no runs.
  std::vector<std::string> objects = {};  ///< all that there are where it is empty
  std::optional<int> runs = {};           ///< per object; the preset's where it is not given
  bool force = false;                     ///< replace runs that were simulated with other settings

  bool include_flagged = false;  ///< flagged runs and intervals are used too
  bool strict = false;           ///< an object of which no run has samples is an error

  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};  ///< t_h, each a whole number of ticks
  std::string train_run = "01";
  std::vector<std::string> held_out;    ///< empty: those of `default_held_out` that the dataset has
  std::optional<unsigned> epochs = {};  ///< the preset's where it is not given
  unsigned seeds = 1;                   ///< trainings of each kind, > 0
  std::uint64_t seed = 1;  ///< of the simulation, the samples, the drawn splits and the first training; the others follow on it
  std::size_t splits = 0;  ///< drawn of all ways to hold so many objects out

  EngineKind engine = EngineKind::fast;              ///< that runs the models
  std::filesystem::path program = "/proc/self/exe";  ///< that trains
  unsigned threads = 0;                              ///< 0: as many as the machine has cores
};

/// What a preset decides beside the simulation.
struct PresetSettings {
  std::vector<std::string> choice_runs;  ///< ids of the runs to choose the history on
  unsigned epochs;
};

/// @throws Error  if there is no such preset
PresetSettings preset_settings(std::string_view preset);

inline constexpr microseconds default_history{40'000};  ///< the paper's, where there is nothing to choose on

}  // namespace tactile
