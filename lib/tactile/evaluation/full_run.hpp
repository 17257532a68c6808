#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "tactile/core/touch.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/inference/decision.hpp"
#include "tactile/results/full_run.hpp"

namespace tactile::evaluation {

struct FullRunOptions {
  unsigned threads = 1;                                 ///< to classify on, > 0; the verdicts do not depend on it
  std::function<void(std::size_t ticks)> advance = {};  ///< called after each batch with its number of ticks; may be empty
  std::optional<microseconds> tick = std::nullopt;      ///< instead of the model's own
  heatmaps::ChangeEvents change = {};                   ///< changes the events first; the ticks stay those of the recording
};

/// Classifies every full tick of a recording by the model's own settings, batch by batch: memory follows the batch, and the
/// ticks.
/// @throws Error   if the recording cannot be read, or its sensor does not suit the model
results::FullRun classify_full_run(const std::filesystem::path& recording, const model::Classifier& classifier,
                                   const FullRunOptions& options = {});

/// The verdict at each tick of a run with probabilities.
std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run);

/// About how many full ticks a recording holds, from its list of packets.
std::size_t expected_ticks(const std::filesystem::path& recording, const heatmaps::HeatmapOptions& options);

}  // namespace tactile::evaluation
