#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

/// The runs that a dataset leaves out because they are flagged: in the folders of its runs `judged`, of their objects. None that
/// the model learned from, that cannot be read, or that is simulated where the dataset is not.
/// @param judged  indexes into the dataset's runs
std::vector<RunFolder> flagged_runs_beside(const windows::Dataset& dataset, std::span<const std::uint32_t> judged,
                                           const model::ModelDescription& model);

}  // namespace tactile::evaluation
