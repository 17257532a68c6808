#pragma once

#include <span>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/results/study.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {

/// The runs that give the dataset no samples, and the flagged intervals of the others, with the reasons; in the order of the
/// runs.
/// @throws Error  if labels cannot be read
std::vector<results::LeftOut> left_out_of(const windows::Dataset& dataset, std::span<const RunFolder> runs);

}  // namespace tactile::study
