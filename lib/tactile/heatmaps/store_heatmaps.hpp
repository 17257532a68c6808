#pragma once

#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::heatmaps {

/// The outcome for one history.
struct StoredHistory {
  windows::StoredHeatmaps heatmaps;
  bool kept = false;  ///< it existed already, with these settings
};

/// Renders the heatmaps of every sample into a dataset, as `/heatmaps/` and `stored_name` of each history. Existing histories are
/// kept. One pass over the events of a run renders all missing histories. Runs are rendered in parallel and written in their
/// order, so memory follows the run.
///
/// @param threads  0: one per core; the bytes do not depend on it
/// @return         one for each of `histories`, in their order; a repeated history is written once, then kept
/// @throws Error   as `check_renders`, or if a file cannot be written; incomplete histories are then not listed
std::vector<StoredHistory> store_heatmaps(const windows::Dataset& dataset, std::span<const HeatmapOptions> histories,
                                          unsigned threads = 0, const ProgressCallback& progress = {});

}  // namespace tactile::heatmaps
