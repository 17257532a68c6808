#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/event_camera_options.hpp"

namespace tactile::simulation {

/// A pixel that fires by itself.
struct SimulatedHotPixel {
  std::uint32_t index = 0;  ///< y * width + x
  double hz = 0;
  double on_share = 0;
  bool stuck = false;

  friend bool operator==(const SimulatedHotPixel&, const SimulatedHotPixel&) = default;
};

/// Draws pixels with probabilities in proportion to their weights, each draw in constant time (Walker's alias method).
class PixelLottery {
 public:
  PixelLottery() = default;
  explicit PixelLottery(const std::vector<double>& weights);  ///< each >= 0

  double weight_sum() const { return weight_sum_; }
  std::uint32_t draw(Random& random) const;  ///< only if the sum is not 0

 private:
  double weight_sum_ = 0;
  std::vector<float> keep_;  ///< chance to take a uniformly drawn pixel instead of `other_`
  std::vector<std::uint32_t> other_;
};

/// The pixels of a camera, the same in all of its runs.
struct CameraPixels {
  std::vector<float> thresholds;  ///< row by row from the top; infinite for dead pixels
  PixelLottery leak;              ///< weights 1 in the mean
  PixelLottery shot;              ///< weights threshold / the pixel's threshold
  // For the background; empty if there is none.
  std::vector<float> background_interval;  ///< mean interval / that of a pixel with the mean rate; 0 for dead pixels
  std::vector<float> background_on_share;
  // Hot and stuck pixels are drawn from these.
  std::uint64_t hot_seed = 0;
  EventCameraOptions hot;
};

/// Draws the pixels. The options of single runs have no effect. @throws Error  if an option is out of range
CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed);

/// The value at the share `share` of a distribution: its quantiles are at equal steps from 0 to 1, linear between them.
double quantile_at(const std::vector<double>& quantiles, double share);

/// The `hot_pixels` hot pixels, then the `stuck_pixels` stuck ones, which fire at every read-out, in the camera's run
/// `run_index`. Between two runs each is replaced, with the chance `hot_turnover`, by another pixel with another rate. Stuck
/// pixels stay. Dead pixels are never hot.
std::vector<SimulatedHotPixel> hot_pixels_of_run(const CameraPixels& pixels, std::size_t run_index);

}  // namespace tactile::simulation
