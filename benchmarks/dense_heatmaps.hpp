#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::bench {

/// Heatmaps by OpenCV over every pixel, as fast as possible: `HeatmapRenderer` is compared with it. It keeps its images,
/// updates the counts by the events that enter and leave the window, and makes no avoidable call. Its bytes equal the
/// renderer's, with the default denoising, except for float32 rounding.
class DenseHeatmaps {
 public:
  DenseHeatmaps(events::SensorSize sensor, double factor);

  void add(std::span<const events::Event> events);     ///< that enter the window
  void forget(std::span<const events::Event> events);  ///< that leave it
  void render();
  std::span<const std::uint8_t> heatmap() const;  ///< [height, width] of `heatmap_size`, as rendered last

 private:
  double factor_;
  cv::Mat1f counts_, denoised_, resized_;
  cv::Mat1b heatmap_;
};

}  // namespace tactile::bench
