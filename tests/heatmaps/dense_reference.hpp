#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::test {

/// E of every pixel, counted the plain way.
inline std::vector<std::uint32_t> dense_counts(const std::vector<events::Event>& events, events::SensorSize sensor,
                                               CameraTime tick, microseconds history) {
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(sensor.width * sensor.height));
  for (const events::Event& event : events) {
    if (event.t >= before(tick, history) && event.t < tick) ++counts[static_cast<std::size_t>(event.y * sensor.width + event.x)];
  }
  return counts;
}

/// Equations 2 to 5 pixel by pixel in long double, straight from their text; [height, width] of the heatmap, not rounded.
inline std::vector<long double> dense_heatmap(const std::vector<std::uint32_t>& counts, events::SensorSize sensor,
                                              const heatmaps::HeatmapOptions& options) {
  long double events = 0, pixels = 0;
  for (const std::uint32_t count : counts) {
    events += count;
    pixels += count > 0 ? 1 : 0;
  }
  const events::SensorSize size{static_cast<int>(std::nearbyint(sensor.width * options.factor)),
                                static_cast<int>(std::nearbyint(sensor.height * options.factor))};
  std::vector<long double> heatmap(static_cast<std::size_t>(size.width * size.height), 0.0L);
  if (pixels == 0) return heatmap;

  const long double b = events / pixels;
  const auto log_of_1_plus_exp = [](long double z) { return z > 0 ? z + std::log1p(std::exp(-z)) : std::log1p(std::exp(z)); };
  std::vector<long double> log_d(counts.size());
  long double largest = -HUGE_VALL;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const long double e = counts[i];
    log_d[i] = std::log(e);  // -infinity where no event is
    if (options.denoise == heatmaps::Denoise::mean) log_d[i] -= log_of_1_plus_exp(e - b);
    if (options.denoise == heatmaps::Denoise::literal) log_d[i] -= log_of_1_plus_exp(e + b);
    largest = std::max(largest, log_d[i]);
  }
  std::vector<long double> m(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) m[i] = 255.0L * std::exp(log_d[i] - largest);

  const int step = static_cast<int>(std::lround(1 / options.factor));
  for (int cy = 0; cy < size.height; ++cy) {
    for (int cx = 0; cx < size.width; ++cx) {
      long double sum = 0, read = 0;
      for (int y = cy * step; y < (cy + 1) * step; ++y) {
        for (int x = cx * step; x < (cx + 1) * step; ++x) {
          const bool central =
              2 * std::abs(x - cx * step - (step - 1) / 2.0) <= 1 && 2 * std::abs(y - cy * step - (step - 1) / 2.0) <= 1;
          if (x >= sensor.width || y >= sensor.height || (options.resize == heatmaps::Resize::linear && !central)) continue;
          sum += m[static_cast<std::size_t>(y * sensor.width + x)];
          ++read;
        }
      }
      heatmap[static_cast<std::size_t>(cy * size.width + cx)] = sum / read;
    }
  }
  return heatmap;
}

}  // namespace tactile::test
