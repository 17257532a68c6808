#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "tactile/core/progress.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::cli {

/// Writes the stored heatmaps of every sample as grey pictures with the same pixels:
/// `folder/th_040/<object>/<run>/<object>-<run>-<t_us>-<class>.png`, with a list of them in `folder/th_040/pictures.csv`. Within
/// a run their names sort by time. Each history's folder appears when it is complete, and replaces earlier pictures.
///
/// @param history  as of `Dataset::find_heatmaps`
/// @param threads  0: the machine's cores
/// @return         the number of pictures
/// @throws Error   as `check_heatmap_pictures`, or if one cannot be written; earlier pictures then stay
std::uint64_t write_heatmap_pictures(const windows::Dataset& dataset, const windows::StoredHeatmaps& history,
                                     const std::filesystem::path& folder, unsigned threads, const ProgressCallback& progress);

/// @throws Error  if something other than earlier pictures is in the place of the history's pictures; call it before rendering
void check_heatmap_pictures(const std::filesystem::path& folder, const std::string& history_name);

}  // namespace tactile::cli
