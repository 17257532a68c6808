#pragma once

#include <cstdint>
#include <string>

#include "options.hpp"
#include "tactile/core/time.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile {

/// How heatmaps are rendered, but for their history: what every command that renders takes.
struct RenderingArguments {
  std::string denoise = "mean", resize = "area";
  double factor = 0.2;
  std::int64_t tick_us = 2000;
};

void add_rendering_options(Command command, RenderingArguments& args);

/// @throws Error  if the history is no whole number of ticks, or an option is out of its range
HeatmapOptions heatmap_options(double history_ms, const RenderingArguments& args);

/// Milliseconds of an option as microseconds. @throws Error, naming the option, if they are no whole number
microseconds whole_us(double ms, const std::string& option);

}  // namespace tactile
