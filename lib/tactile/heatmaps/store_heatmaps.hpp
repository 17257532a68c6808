#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::heatmaps {

/// The outcome for one history.
struct StoredHistory {
  windows::StoredHeatmaps heatmaps;
  bool kept = false;  ///< it existed already, with these settings
  std::size_t runs_rendered = 0;
  std::size_t runs_kept = 0;  ///< taken from the file of an older dataset
  std::string warning;        ///< a sentence: why runs of an older dataset could not be kept; empty if they could
};

/// Renders the heatmaps of every sample into a dataset, as `/heatmaps/` and `stored_name` of each history. Existing histories are
/// kept. A history of an older dataset is replaced: it gives its heatmaps of the runs with the same recording and samples, and
/// the others are rendered. The bytes are those of a history that is rendered at once. One pass over the events of a run renders
/// all missing histories. Runs are rendered in parallel and written in their order, so memory follows the run.
///
/// @param threads  0: one per core; the bytes do not depend on it
/// @return         one for each of `histories`, in their order; a repeated history is written once, then kept
/// @throws Error   as `check_renders`, or if a file cannot be written; incomplete histories are then not listed
std::vector<StoredHistory> store_heatmaps(const windows::Dataset& dataset, std::span<const HeatmapOptions> histories,
                                          unsigned threads = 0, const ProgressCallback& progress = {});

}  // namespace tactile::heatmaps
