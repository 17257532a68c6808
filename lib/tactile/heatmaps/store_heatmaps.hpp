#pragma once

#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// What became of one history.
struct StoredHistory {
  StoredHeatmaps heatmaps;
  bool kept = false;  ///< it was there already, with these settings
};

/// Renders the heatmaps of every sample into a dataset, as `/heatmaps/` and `stored_name` of each history; those that are there
/// are kept. One pass over the events of a run renders all the others; runs are rendered in parallel and written as they come, so
/// memory follows the run.
///
/// @param threads  0: as many as the machine has cores; the bytes do not depend on it
/// @return         one for each of `histories`, in their order; one that is named twice is written once, and then kept
/// @throws Error   as `check_renders`, or if a file cannot be written; histories that are not whole are not listed then
std::vector<StoredHistory> store_heatmaps(const Dataset& dataset, std::span<const HeatmapOptions> histories, unsigned threads = 0,
                                          const ProgressCallback& progress = {});

}  // namespace tactile
