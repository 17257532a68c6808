#pragma once

#include <string>

#include "options.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::cli {

/// --mask, of every command that leaves out pixels.
Option add_mask_option(Command command, std::string& mask);

/// The same with the mask of a file, unless there is none.
/// @throws Error  if the history is not a whole number of ticks, or the factor does not divide 1
heatmaps::HeatmapOptions with_mask(heatmaps::HeatmapOptions options, const std::string& mask);

/// @throws Error  that names the mask's file, if one of its pixels lies outside the sensor
void check_mask(const std::string& mask, const heatmaps::HeatmapOptions& options, events::SensorSize sensor);

}  // namespace tactile::cli
