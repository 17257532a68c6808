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

namespace {

/// Quantiles of the normal distribution, in the middles of equal steps of probability.
const std::vector<double>& normal_quantiles() {
  static const std::vector<double> quantiles = [] {
    std::vector<double> found(1 << 12);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(found.size());
      double low = -5, high = 5;
      while (high - low > 1e-9) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle / std::numbers::sqrt2) < share ? low : high) = middle;
      }
      found[i] = low;
    }
    return found;
  }();
  return quantiles;
}

/// Each pixel's own rate, log-normal with the mean kept, and share of ON events, normal and cut to 0 to 1.
void draw_background(CameraPixels& pixels, const EventCameraOptions& options, std::uint64_t seed) {
  const std::vector<double>& normals = normal_quantiles();
  const double spread = options.background_spread_decades * std::numbers::ln10, mean = std::exp(0.5 * spread * spread);
  std::vector<float> intervals, shares;
  for (const double normal : normals) {
    intervals.push_back(static_cast<float>(mean * std::exp(spread * normal)));
    const double share = options.background_on_share + options.background_on_spread * normal;
    shares.push_back(static_cast<float>(std::clamp(share, 0.0, 1.0)));
  }
  Random random(seed);
  const std::size_t count = pixels.thresholds.size();
  pixels.background_interval.assign(count, 0.0F);
  pixels.background_on_share.assign(count, 0.0F);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random.bits();
    if (std::isinf(pixels.thresholds[i])) continue;
    pixels.background_interval[i] = intervals[bits >> 52];
    pixels.background_on_share[i] = shares[bits >> 40 & 0xfff];
  }
}

}  // namespace

CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed) {
  check(options);
  Random random(seed);
  const std::size_t count = pixel_count(options.size);
  CameraPixels pixels;
  pixels.thresholds.reserve(count);
  // A camera with a measured background seldom has these too.
  const bool leaks = options.leak_hz > 0 || !(options.background_hz > 0),
             shoots = options.shot_hz > 0 || !(options.background_hz > 0);
  std::vector<double> leak(count), shot(count);
  // A log-normal with this spread has a mean above 1; the division restores the nominal mean rate.
  const double spread = options.leak_spread_decades * std::numbers::ln10;
  const double mean = std::exp(0.5 * spread * spread);
  for (std::size_t i = 0; i < count; ++i) {
    const double threshold = std::max(options.threshold_floor, options.threshold + options.threshold_sigma * random.normal());
    pixels.thresholds.push_back(static_cast<float>(threshold));
    if (leaks) leak[i] = std::exp(spread * random.normal()) / mean;
    shot[i] = options.threshold / threshold;
  }
  for (int dead = 0; dead < options.dead_pixels;) {
    const std::uint64_t i = random.below(count);
    if (std::isinf(pixels.thresholds[i])) continue;
    pixels.thresholds[i] = std::numeric_limits<float>::infinity();
    leak[i] = shot[i] = 0;
    ++dead;
  }
  if (leaks) pixels.leak = PixelLottery(leak);
  if (shoots) pixels.shot = PixelLottery(shot);
  pixels.hot_seed = random.bits();
  pixels.hot = options;
  if (options.background_hz > 0) draw_background(pixels, options, seed_for(seed, {"background"}));
  return pixels;
}

double quantile_at(const std::vector<double>& quantiles, double share) {
  if (quantiles.size() == 1) return quantiles.front();
  const double place = share * static_cast<double>(quantiles.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), quantiles.size() - 2);
  return quantiles[below] + (place - static_cast<double>(below)) * (quantiles[below + 1] - quantiles[below]);
}

std::vector<SimulatedHotPixel> hot_pixels_of_run(const CameraPixels& pixels, std::size_t run_index) {
  const EventCameraOptions& options = pixels.hot;
  std::vector<double> log_hz;
  for (const double hz : options.hot_hz) log_hz.push_back(std::log(hz));
  const auto draw_place = [&](Random& random) {
    std::uint64_t index = random.below(pixels.thresholds.size());
    while (std::isinf(pixels.thresholds[index])) index = random.below(pixels.thresholds.size());
    return static_cast<std::uint32_t>(index);
  };
  std::vector<SimulatedHotPixel> hot;
  for (int i = 0; i < options.hot_pixels; ++i) {
    Random random(seed_for(pixels.hot_seed, {"hot pixel", std::to_string(i)}));
    const auto born = [&] {
      SimulatedHotPixel pixel{.index = draw_place(random)};
      pixel.hz = std::exp(quantile_at(log_hz, random.uniform()));
      pixel.on_share = quantile_at(options.hot_on_shares, options.hot_on_shares.size() > 1 ? random.uniform() : 0.0);
      return pixel;
    };
    SimulatedHotPixel pixel = born();
    for (std::size_t run = 0; run < run_index; ++run) {
      if (random.uniform() < options.hot_turnover) pixel = born();
    }
    hot.push_back(pixel);
  }
  for (int i = 0; i < options.stuck_pixels; ++i) {
    Random random(seed_for(pixels.hot_seed, {"stuck pixel", std::to_string(i)}));
    hot.push_back(
        {.index = draw_place(random), .hz = 1e6 / options.readout_us, .on_share = options.stuck_on_share, .stuck = true});
  }
  return hot;
}

}  // namespace tactile::simulation
