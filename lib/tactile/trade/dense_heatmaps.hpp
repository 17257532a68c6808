#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "tactile/events/event.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile {

/// Heatmaps as fast as they go over every pixel by OpenCV: what `HeatmapRenderer` is measured beside, never used to detect.
/// Images are kept, a count image takes the events that come and go, and no call is made that another can do without. The bytes
/// are the renderer's but for rounding in float32, by the default way of denoising.
class DenseHeatmaps {
 public:
  DenseHeatmaps(SensorSize sensor, double factor);

  void add(std::span<const Event> events);     ///< that come into the window
  void forget(std::span<const Event> events);  ///< that leave it
  void render();
  std::span<const std::uint8_t> heatmap() const;  ///< [height, width] of `heatmap_size`, as rendered last

 private:
  double factor_;
  cv::Mat1f counts_, denoised_, resized_;
  cv::Mat1b heatmap_;
};

}  // namespace tactile
