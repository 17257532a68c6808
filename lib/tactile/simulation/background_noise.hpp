#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/camera_pixels.hpp"
#include "tactile/simulation/event_camera_options.hpp"

namespace tactile::simulation {

/// The events without cause of ordinary pixels. Those of a pixel are a renewal process: its intervals have a gamma distribution
/// with the shape `background_regularity` and a mean of the pixel's own. With the shape 1 the process is Poisson; above it, a
/// pixel rests after an event. The process has begun long before the first read-out. An event of another cause does not change
/// it.
class BackgroundNoise {
 public:
  BackgroundNoise(const CameraPixels& pixels, const EventCameraOptions& options, std::uint64_t seed);

  /// Calls `fire(index, on)` for each event until read-out `readout`, in a fixed order. Read-outs must ascend.
  template <class Fire>
  void advance(std::uint32_t readout, const Fire& fire) {
    for (; now_ <= readout && !due_.empty(); ++now_) {
      std::uint32_t pixel = std::exchange(first_[now_ % first_.size()], no_pixel);
      while (pixel != no_pixel) {
        const std::uint32_t later = next_[pixel];
        if (due_[pixel] <= now_) {
          fire(pixel, random_.uniform() < static_cast<double>(pixels_->background_on_share[pixel]));
          due_[pixel] = now_ + readouts_until(pixel, intervals_);
        }
        insert(pixel);
        pixel = later;
      }
    }
  }

 private:
  static constexpr std::uint32_t no_pixel = 0xffff'ffff;

  std::uint32_t readouts_until(std::uint32_t pixel, const std::vector<float>& quantiles);
  void insert(std::uint32_t pixel);

  const CameraPixels* pixels_;
  double mean_readouts_ = 0;  ///< of the intervals of a pixel with the mean rate
  Random random_;
  std::vector<float> intervals_;  ///< quantiles, with the mean 1
  std::uint32_t now_ = 0;
  // Each pixel is in the list of the read-out at which it is due, or of the last one that the ring reaches.
  std::vector<std::uint32_t> first_, next_, due_;
};

/// `count` quantiles of the gamma distribution with this shape and mean, in the middles of equal steps of probability.
std::vector<float> gamma_quantiles(double shape, double mean, std::size_t count);

}  // namespace tactile::simulation
