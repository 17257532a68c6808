#include "dense_heatmaps.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace tactile::bench {

DenseHeatmaps::DenseHeatmaps(events::SensorSize sensor, double factor)
    : factor_(factor), counts_(cv::Mat1f::zeros(sensor.height, sensor.width)) {
  const events::SensorSize size = heatmaps::heatmap_size(sensor, factor);
  heatmap_ = cv::Mat1b::zeros(size.height, size.width);
}

void DenseHeatmaps::add(std::span<const events::Event> events) {
  for (const events::Event& event : events) counts_(event.y, event.x) += 1;
}

void DenseHeatmaps::forget(std::span<const events::Event> events) {
  for (const events::Event& event : events) counts_(event.y, event.x) -= 1;
}

void DenseHeatmaps::render() {
  const double mean = cv::sum(counts_)[0] / std::max(cv::countNonZero(counts_), 1);
  cv::subtract(counts_, mean, denoised_);
  cv::exp(denoised_, denoised_);
  cv::add(denoised_, 1.0, denoised_);
  cv::divide(counts_, denoised_, denoised_);
  double largest = 0;
  cv::minMaxLoc(denoised_, nullptr, &largest);
  cv::resize(denoised_, resized_, {}, factor_, factor_, cv::INTER_AREA);
  resized_.convertTo(heatmap_, CV_8U, largest > 0 ? 255.0 / largest : 0.0);
}

std::span<const std::uint8_t> DenseHeatmaps::heatmap() const { return {heatmap_.data, heatmap_.total()}; }

}  // namespace tactile::bench
