#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/pictures/gnuplot.hpp"

namespace tactile::pictures {

/// What the sensor gave over one history, and what the network is shown of it.
struct TouchFrame {
  std::string caption;        ///< over it: "press, 30 ms after its onset"
  Touch touch = Touch::none;  ///< colours the caption
  std::uint64_t events = 0;   ///< in the history
  cv::Mat raw;                ///< [height, width] float32: events per pixel, or per block of 2 x 2, 3 x 3 ... of a large sensor
  cv::Mat heatmap;            ///< [height, width] uint8, noise reduced
};

/// Frames of a labelled run: before its first press and its first slip, and shortly after their onsets. Empty where it has
/// neither, or is not labelled.
/// @throws Error  if the recording or the labels cannot be read, or as `check(options)`
std::vector<TouchFrame> frames_of(const RunFolder& run, const heatmaps::HeatmapOptions& options);

/// Raw frames over noise-reduced ones, a moment a column; brighter by the square root of a cell's value, by the same scale in a
/// row.
/// @throws Error  if there is no frame, or one without pictures
Plot frames_plot(const std::string& title, const std::vector<TouchFrame>& frames);

}  // namespace tactile::pictures
