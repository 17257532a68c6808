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

/// Renders every full tick of a recording with the model's own settings and classifies it, batch by batch: memory follows the
/// batch, and the ticks.
///
/// @param threads  to classify on, > 0; the verdicts do not depend on it
/// @param advance  called after each batch with its number of ticks; may be empty
/// @param see      called with each rendered tick; may be empty
/// @param tick     instead of the model's own
/// @param change   changes the events before they are rendered; the ticks stay those of the recording
/// @throws Error   if the recording cannot be read, or its sensor gives heatmaps of another size than the model's
results::FullRun classify_full_run(const std::filesystem::path& recording, const model::Classifier& classifier, unsigned threads,
                                   const std::function<void(std::size_t ticks)>& advance = {},
                                   const heatmaps::TickCallback& see = {}, std::optional<microseconds> tick = {},
                                   const heatmaps::ChangeEvents& change = {});

/// The verdict at each tick of a run with probabilities.
std::vector<Touch> decided(const model::Decision& decision, const results::FullRun& run);

/// Sets the ticks at which the gate is closed to none, with the probabilities {1, 0, 0}, as if the network had not run.
/// @return  the number of these ticks
std::uint64_t apply_gate(results::FullRun& run, const model::GateRule& rule);

/// About how many full ticks a recording holds, from its list of packets.
std::size_t expected_ticks(const std::filesystem::path& recording, const heatmaps::HeatmapOptions& options);

}  // namespace tactile::evaluation
