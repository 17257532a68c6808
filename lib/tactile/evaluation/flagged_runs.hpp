#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

/// The runs that a dataset leaves out because they are flagged, in the same folders and of the same objects as its runs
/// `judged`. Runs that the model learned from and runs that cannot be read are not among them, nor simulated runs if the
/// dataset is real.
/// @param judged  indexes into the dataset's runs
std::vector<RunFolder> flagged_runs_beside(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                                           const model::ModelDescription& model);

}  // namespace tactile::evaluation
