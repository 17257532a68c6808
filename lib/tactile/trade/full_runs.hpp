#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/results/full_run.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// Renders every full tick of several of the dataset's runs by the classifier's settings, but at this tick, and classifies it.
/// @return  the runs in their order, without probabilities
/// @throws Error  as `classify_full_run`
std::vector<FullRun> classify_full_runs(const Dataset& dataset, std::span<const std::uint32_t> runs, const Classifier& classifier,
                                        microseconds tick, unsigned threads, const ProgressCallback& progress = {});

/// The same at a tick that is a whole number of the old ones: what `classify_full_runs` gives at it, since a heatmap depends on
/// the events of its history alone. @throws Error  if it is not
FullRun at_tick(const FullRun& run, microseconds tick);

/// The verdicts at each tick: none below the gate's limit, then confirmed.
std::vector<Touch> verdicts_of(const FullRun& run, std::optional<std::uint64_t> gate, const Confirmation& confirmation);

/// {"runs": []}, whole or not at all.
void write_full_runs(const std::filesystem::path& file, std::span<const FullRun> runs);
std::vector<FullRun> read_full_runs(const std::filesystem::path& file);  ///< @throws Error  if it is no such file

}  // namespace tactile
