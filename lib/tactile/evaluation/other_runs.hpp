#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/results/whole_runs.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::evaluation {

/// Whether the dataset uses labels that are in doubt.
bool includes_flagged(const windows::Dataset& dataset);

/// Runs beside those with samples.
struct OtherRuns {
  std::vector<RunFolder> runs;
  std::vector<results::LeftOutRun> left_out;  ///< that cannot be judged
};

/// The other runs in the data folder, of objects that the split tests: those that the dataset has no samples
/// of, because they lack a press or a slip without a flag. A run without a truth whose labels are flagged as a whole is left out,
/// except where the dataset uses flagged labels; so is one that cannot be read, or of another sensor.
/// @param judged    runs of the dataset
/// @param split     of the model: a single-run split tests all objects, another those held out
/// @param is_known  of the runs that are passed over: a model learned from them; may be empty
OtherRuns other_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> judged, const windows::SplitOptions& split,
                     const std::function<bool(const RunFolder&)>& is_known = {});

/// The same of a model: those that it did not learn from.
OtherRuns other_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                     const model::ModelDescription& model);

}  // namespace tactile::evaluation
