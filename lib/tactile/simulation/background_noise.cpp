#include "tactile/simulation/background_noise.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::simulation {
namespace {

constexpr std::size_t ring_readouts = 1 << 15;
constexpr std::size_t quantile_count = 1 << 12;

}  // namespace

std::vector<float> gamma_quantiles(double shape, double mean, std::size_t count) {
  // In u = ln x the density exp(shape u - e^u) is smooth for every shape; it is summed from where it is nothing.
  constexpr std::size_t steps = 20'000;
  const double low = std::log(shape) - 14.0 / std::min(1.0, shape) - 2.0;
  const double high = std::log(shape + 12.0 * std::sqrt(shape) + 20.0), step = (high - low) / steps;
  const double peak = shape * std::log(shape) - shape;
  std::vector<double> sums(steps + 1, 0.0);
  for (std::size_t i = 0; i < steps; ++i) {
    const double u = low + (static_cast<double>(i) + 0.5) * step;
    sums[i + 1] = sums[i] + std::exp(shape * u - std::exp(u) - peak);
  }
  std::vector<double> quantiles(count);
  double sum = 0;
  std::size_t i = 0;
  for (std::size_t q = 0; q < count; ++q) {
    const double wanted = (static_cast<double>(q) + 0.5) / static_cast<double>(count) * sums.back();
    while (sums[i + 1] < wanted) ++i;
    quantiles[q] = std::exp(low + (static_cast<double>(i) + (wanted - sums[i]) / (sums[i + 1] - sums[i])) * step);
    sum += quantiles[q];
  }
  std::vector<float> scaled(count);
  const double factor = mean * static_cast<double>(count) / sum;
  std::transform(quantiles.begin(), quantiles.end(), scaled.begin(), [&](double x) { return static_cast<float>(factor * x); });
  return scaled;
}

BackgroundNoise::BackgroundNoise(const CameraPixels& pixels, const EventCameraOptions& options, std::uint64_t seed)
    : pixels_(&pixels), random_(seed) {
  const double hz = options.background_hz * options.noise_factor;
  if (!(hz > 0) || pixels.background_interval.empty()) return;
  mean_readouts_ = 1e6 / (hz * options.readout_us);
  const double shape = options.background_regularity;
  intervals_ = gamma_quantiles(shape, 1.0, quantile_count);
  // An interval that contains a given time is longer: its distribution is weighted with its length.
  const std::vector<float> containing = gamma_quantiles(shape + 1.0, (shape + 1.0) / shape, quantile_count);
  const std::size_t count = pixels.background_interval.size();
  first_.assign(ring_readouts, no_pixel);
  next_.assign(count, no_pixel);
  due_.assign(count, 0);
  for (std::uint32_t pixel = 0; pixel < count; ++pixel) {
    if (!(pixels.background_interval[pixel] > 0)) continue;
    due_[pixel] = static_cast<std::uint32_t>(random_.uniform() * readouts_until(pixel, containing));
    insert(pixel);
  }
}

/// At least 1 and at most a billion, which is longer than two days.
std::uint32_t BackgroundNoise::readouts_until(std::uint32_t pixel, const std::vector<float>& quantiles) {
  const auto interval = static_cast<double>(quantiles[random_.bits() >> (64 - 12)]);
  const double readouts = interval * mean_readouts_ * static_cast<double>(pixels_->background_interval[pixel]);
  return static_cast<std::uint32_t>(std::clamp(readouts + 0.5, 1.0, 1e9));
}

void BackgroundNoise::insert(std::uint32_t pixel) {
  const std::uint32_t farthest = now_ + static_cast<std::uint32_t>(ring_readouts) - 1;
  std::uint32_t& first = first_[std::min(due_[pixel], farthest) % ring_readouts];
  next_[pixel] = std::exchange(first, pixel);
}

}  // namespace tactile::simulation
