#pragma once

#include "tactile/windows/dataset.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::windows {

/// The split of a dataset's runs; those without samples cannot train. @throws Error  as the other `split_runs`
Split split_runs(const Dataset& dataset, const SplitOptions& options);

}  // namespace tactile::windows
