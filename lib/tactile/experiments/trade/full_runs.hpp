#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/inference/decision.hpp"
#include "tactile/results/full_run.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::trade {

/// Renders and classifies every full tick of these runs, by the classifier's settings except for the tick.
/// @param options  its tick and its ratios are used; each run is classified on one of its threads
/// @return  the runs in their order
/// @throws Error  as `classify_full_run`
std::vector<results::FullRun> classify_full_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                                                 const model::Classifier& classifier, const evaluation::FullRunOptions& options,
                                                 const ProgressCallback& progress = {});

/// The same run at a tick that is a multiple of its own: equal to what `classify_full_runs` gives, because a heatmap depends only
/// on the events of its history. @throws Error  if it is no multiple
results::FullRun at_tick(const results::FullRun& run, microseconds tick);

/// The verdict at each tick: none below the gate's limit, then confirmed or filtered.
std::vector<Touch> verdicts_of(results::FullRun run, std::optional<model::GateRule> gate, const model::Decision& decision);

/// {"runs": []}, complete or not at all.
void write_full_runs(const std::filesystem::path& file, std::span<const results::FullRun> runs);
std::vector<results::FullRun> read_full_runs(const std::filesystem::path& file);  ///< @throws Error  if it has another form

}  // namespace tactile::trade
