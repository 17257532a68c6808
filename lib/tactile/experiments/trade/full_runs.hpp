#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/results/full_run.hpp"

namespace tactile::trade {

/// Classifies every full tick of these runs, by the classifier's settings except for the tick.
/// @param options  its tick is used; each run is classified on one of its threads
/// @return  the runs in their order
/// @throws Error  as `classify_full_run`
std::vector<results::FullRun> classify_full_runs(std::span<const RunFolder> runs, const model::Classifier& classifier,
                                                 const evaluation::FullRunOptions& options,
                                                 const ProgressCallback& progress = {});

/// The same run at a tick that is a multiple of its own: equal to what `classify_full_runs` gives, because a heatmap depends only
/// on the events of its history. @throws Error  if it is no multiple
results::FullRun at_tick(const results::FullRun& run, microseconds tick);

/// {"runs": []}, complete or not at all.
void write_full_runs(const std::filesystem::path& file, std::span<const results::FullRun> runs);
std::vector<results::FullRun> read_full_runs(const std::filesystem::path& file);  ///< @throws Error  if it has another form

}  // namespace tactile::trade
