#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "tactile/core/progress.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// Writes the stored heatmaps of every sample as grey pictures, their pixels the heatmaps' own:
/// `folder/th_040/<object>/<run>/<object>-<run>-<t_us>-<class>.png`, with a list of them in `folder/th_040/pictures.csv`. Within
/// a run their names sort by time. Each history's folder appears whole; one of earlier pictures is replaced.
///
/// @param history  as `Dataset::find_heatmaps` knows it
/// @param threads  0: as many as the machine has cores
/// @return         how many were written
/// @throws Error   as `check_heatmap_pictures`, or if one cannot be written; what was there then still is
std::uint64_t write_heatmap_pictures(const Dataset& dataset, const StoredHeatmaps& history, const std::filesystem::path& folder,
                                     unsigned threads, const ProgressCallback& progress);

/// @throws Error  if something else than earlier pictures is where those of the history go: to be asked before they are rendered
void check_heatmap_pictures(const std::filesystem::path& folder, const std::string& history_name);

}  // namespace tactile
