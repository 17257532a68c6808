#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/detect/reported_tick.hpp"

namespace tactile::cli {

/// Draws probabilities and events over time and, if a run folder is known, its labels and truth: each onset, the first right
/// verdict and the delay. Draws only the ticks since the last restart of the stream. A skipped tick shows the verdict before it.
/// @throws Error  if there is no tick, or as `draw_prediction`
void draw_ticks(const std::vector<detect::ReportedTick>& ticks, const heatmaps::HeatmapOptions& rendering,
                const std::string& title, const std::optional<RunFolder>& run, const std::filesystem::path& file);

}  // namespace tactile::cli
