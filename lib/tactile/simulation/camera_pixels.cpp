#include "tactile/simulation/camera_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace tactile::simulation {

PixelLottery::PixelLottery(const std::vector<double>& weights) : keep_(weights.size(), 1.0F), other_(weights.size()) {
  for (const double weight : weights) weight_sum_ += weight;
  if (!(weight_sum_ > 0)) return;
  // A pixel with less than the mean weight shares its place with one with more.
  std::vector<double> left(weights);
  std::vector<std::uint32_t> less, more;
  const double mean = weight_sum_ / static_cast<double>(weights.size());
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    other_[i] = i;
    (weights[i] < mean ? less : more).push_back(i);
  }
  while (!less.empty() && !more.empty()) {
    const std::uint32_t small = less.back(), large = more.back();
    less.pop_back();
    keep_[small] = static_cast<float>(left[small] / mean);
    other_[small] = large;
    left[large] -= mean - left[small];
    if (left[large] < mean) {
      more.pop_back();
      less.push_back(large);
    }
  }
}

std::uint32_t PixelLottery::draw(Random& random) const {
  const std::uint64_t bits = random.bits();
  const auto place = static_cast<std::uint32_t>(((bits >> 32) * keep_.size()) >> 32);
  const float share = static_cast<float>((bits >> 8) & 0xff'ffff) * 0x1.0p-24F;
  return share < keep_[place] ? place : other_[place];
}

CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed) {
  check(options);
  Random random(seed);
  const std::size_t count = pixel_count(options.size);
  CameraPixels pixels;
  pixels.thresholds.reserve(count);
  std::vector<double> leak(count), shot(count);
  // A log-normal with this spread has a mean above 1; the division restores the nominal mean rate.
  const double spread = options.leak_spread_decades * std::numbers::ln10;
  const double mean = std::exp(0.5 * spread * spread);
  for (std::size_t i = 0; i < count; ++i) {
    const double threshold = std::max(options.threshold_floor, options.threshold + options.threshold_sigma * random.normal());
    pixels.thresholds.push_back(static_cast<float>(threshold));
    leak[i] = std::exp(spread * random.normal()) / mean;
    shot[i] = options.threshold / threshold;
  }
  for (int dead = 0; dead < options.dead_pixels;) {
    const std::uint64_t i = random.below(count);
    if (std::isinf(pixels.thresholds[i])) continue;
    pixels.thresholds[i] = std::numeric_limits<float>::infinity();
    leak[i] = shot[i] = 0;
    ++dead;
  }
  pixels.leak = PixelLottery(leak);
  pixels.shot = PixelLottery(shot);
  pixels.hot_seed = random.bits();
  pixels.hot_pixels = options.hot_pixels;
  pixels.hot_min_hz = options.hot_min_hz;
  pixels.hot_max_hz = options.hot_max_hz;
  pixels.hot_turnover = options.hot_turnover;
  return pixels;
}

std::vector<SimulatedHotPixel> hot_pixels_of_run(const CameraPixels& pixels, std::size_t run_index) {
  std::vector<SimulatedHotPixel> hot;
  for (int i = 0; i < pixels.hot_pixels; ++i) {
    Random random(seed_for(pixels.hot_seed, {"hot pixel", std::to_string(i)}));
    const auto born = [&] {
      std::uint64_t index = random.below(pixels.thresholds.size());
      while (std::isinf(pixels.thresholds[index])) index = random.below(pixels.thresholds.size());
      const double hz = pixels.hot_min_hz * std::pow(pixels.hot_max_hz / pixels.hot_min_hz, random.uniform());
      return SimulatedHotPixel{static_cast<std::uint32_t>(index), hz};
    };
    SimulatedHotPixel pixel = born();
    for (std::size_t run = 0; run < run_index; ++run) {
      if (random.uniform() < pixels.hot_turnover) pixel = born();
    }
    hot.push_back(pixel);
  }
  return hot;
}

}  // namespace tactile::simulation
