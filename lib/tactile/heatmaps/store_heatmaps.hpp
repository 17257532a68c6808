#pragma once

#include <string>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// What became of one history.
struct StoredHistory {
  StoredHeatmaps heatmaps;
  bool kept = false;  ///< it was there already, with these settings
};

/// Renders the heatmaps of every sample into a dataset, as `/heatmaps/` and `stored_name(options)`; one that is there is kept.
/// Runs are rendered in parallel and written as they come, so memory follows the run.
///
/// @param threads  0: as many as the machine has cores; the bytes do not depend on it
/// @throws Error   as `check_renders`, or if the file cannot be written; the dataset then is what it was
StoredHistory store_heatmaps(const Dataset& dataset, const HeatmapOptions& options, unsigned threads = 0,
                             const ProgressCallback& progress = {});

}  // namespace tactile
