#pragma once

#include <cstdint>
#include <string>

#include "options.hpp"
#include "tactile/core/time.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::cli {

/// How heatmaps are rendered, except for their history: options of every command that renders.
struct RenderingArguments {
  std::string denoise = "mean", resize = "area";
  double factor = 0.2;
  std::int64_t tick_us = 2000;
  std::string mask;  ///< a mask's file; empty: none
};

void add_rendering_options(Command command, RenderingArguments& args);

/// --mask, of every command that leaves out pixels.
Option add_mask_option(Command command, std::string& mask);

/// @throws Error  if the history is not a whole number of ticks, or an option is out of range
heatmaps::HeatmapOptions heatmap_options(double history_ms, const RenderingArguments& args);

/// @throws Error  that names the mask's file, if one of its pixels lies outside the sensor
void check_mask(const RenderingArguments& args, const heatmaps::HeatmapOptions& options, events::SensorSize sensor);

/// Milliseconds of an option as microseconds. @throws Error  that names the option, if they are not a whole number
microseconds whole_us(double ms, const std::string& option);

}  // namespace tactile::cli
