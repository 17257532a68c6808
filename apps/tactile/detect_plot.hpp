#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/detect/live_detector.hpp"

namespace tactile {

/// Draws what was told over time beside the events and, where a run's folder is known, beside its labels and truth: each onset,
/// the first right verdict and the delay. Only the ticks since the stream last began anew; one that was skipped shows the verdict
/// before it. @throws Error  if there is no tick, or as `draw_prediction`
void draw_told_ticks(const std::vector<ToldTick>& ticks, const HeatmapOptions& rendering, const std::string& title,
                     const std::optional<RunFolder>& run, const std::filesystem::path& file);

}  // namespace tactile
