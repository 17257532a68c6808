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
  heatmaps::TickCallback see = {};                      ///< called with each rendered tick of a model that reads heatmaps
  std::optional<microseconds> tick = std::nullopt;      ///< instead of the model's own
  heatmaps::ChangeEvents change = {};                   ///< changes the events first; the ticks stay those of the recording
  bool ratios = false;                                  ///< computes the `BackgroundRatio` of each tick, for a gate
};

/// Whether a gate needs `FullRunOptions::ratios`.
bool needs_ratios(const std::optional<model::GateRule>& gate);

/// Classifies every full tick of a recording by the model's own settings, batch by batch: memory follows the batch, and the
/// ticks.
/// @throws Error   if the recording cannot be read, or its sensor does not suit the model
results::FullRun classify_full_run(const std::filesystem::path& recording, const model::Classifier& classifier,
                                   const FullRunOptions& options = {});

/// The verdict at each tick of a run with probabilities.
std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run);

/// Sets the ticks at which the gate is closed to none, with the probabilities {1, 0, 0}, as if the network had not run.
/// @return  the number of these ticks
/// @throws Error  if the rule compares ratios, and the run has none
std::uint64_t apply_gate(results::FullRun& run, const model::GateRule& rule);

/// About how many full ticks a recording holds, from its list of packets.
std::size_t expected_ticks(const std::filesystem::path& recording, const heatmaps::HeatmapOptions& options);

}  // namespace tactile::evaluation
