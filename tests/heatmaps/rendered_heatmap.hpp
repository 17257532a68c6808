#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "heatmaps/dense_reference.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::test {

/// A pixel and how many events it has.
struct Hits {
  int x = 0, y = 0;
  std::uint32_t count = 1;
};

/// A renderer whose window holds these events and no others.
inline heatmaps::HeatmapRenderer renderer_of(const std::vector<Hits>& pixels, events::SensorSize sensor,
                                             const heatmaps::HeatmapOptions& options) {
  heatmaps::HeatmapRenderer renderer(sensor, options);
  std::vector<events::Event> events;
  for (const Hits& pixel : pixels) {
    for (std::uint32_t left = pixel.count; left > 0; left -= std::min(left, 100'000U)) {
      events.assign(std::min(left, 100'000U),
                    events::Event{.t = {}, .x = static_cast<std::int16_t>(pixel.x), .y = static_cast<std::int16_t>(pixel.y)});
      renderer.add(events);
    }
  }
  renderer.move_to(CameraTime{options.history});
  return renderer;
}

template <class T>
std::vector<T> rendered(heatmaps::HeatmapRenderer& renderer) {
  std::vector<T> heatmap(static_cast<std::size_t>(renderer.size().width * renderer.size().height), T{77});
  renderer.render(std::span(heatmap));
  return heatmap;
}

template <class T>
std::vector<T> rendered(const std::vector<Hits>& pixels, events::SensorSize sensor, const heatmaps::HeatmapOptions& options) {
  heatmaps::HeatmapRenderer renderer = renderer_of(pixels, sensor, options);
  return rendered<T>(renderer);
}

inline std::vector<std::uint32_t> dense_counts(const std::vector<Hits>& pixels, events::SensorSize sensor) {
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(sensor.width * sensor.height));
  for (const Hits& pixel : pixels) counts[static_cast<std::size_t>(pixel.y * sensor.width + pixel.x)] += pixel.count;
  return counts;
}

/// Every method to denoise and to resize.
inline std::vector<heatmaps::HeatmapOptions> every_method(double factor = 0.2) {
  std::vector<heatmaps::HeatmapOptions> methods;
  for (const heatmaps::Denoise denoise : {heatmaps::Denoise::mean, heatmaps::Denoise::literal, heatmaps::Denoise::none}) {
    for (const heatmaps::Resize resize : {heatmaps::Resize::area, heatmaps::Resize::linear})
      methods.push_back({.history = std::chrono::milliseconds{40}, .denoise = denoise, .resize = resize, .factor = factor});
  }
  return methods;
}

/// Whether floats are within 1e-6 of the true value or 1e-30, and bytes those of the true value, but where that lies within 1e-3
/// of where it would be rounded to another.
inline testing::AssertionResult is_true(heatmaps::HeatmapRenderer& renderer, const std::vector<std::uint32_t>& counts,
                                        events::SensorSize sensor) {
  const auto expected = dense_heatmap(counts, sensor, renderer.options());
  const auto floats = rendered<float>(renderer);
  const auto bytes = rendered<std::uint8_t>(renderer);
  if (floats.size() != expected.size()) return testing::AssertionFailure() << floats.size() << " cells, not " << expected.size();
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const long double to_boundary = std::abs(expected[i] + 0.5L - std::round(expected[i] + 0.5L));
    const bool float_is_true = std::abs(floats[i] - expected[i]) <= std::max(1e-6L * expected[i], 1e-30L);
    const bool byte_is_true = to_boundary <= 1e-3L ? std::abs(bytes[i] - expected[i]) <= 0.501L
                                                   : bytes[i] == static_cast<int>(std::floor(expected[i] + 0.5L));
    if (float_is_true && byte_is_true) continue;
    return testing::AssertionFailure() << "cell " << i << " of " << sensor.width << "x" << sensor.height << " px with "
                                       << nlohmann::json(renderer.options()).dump() << " is " << floats[i] << " and "
                                       << int{bytes[i]} << ", not " << static_cast<double>(expected[i]);
  }
  return testing::AssertionSuccess();
}

inline testing::AssertionResult is_true(const std::vector<Hits>& pixels, events::SensorSize sensor,
                                        const heatmaps::HeatmapOptions& options) {
  heatmaps::HeatmapRenderer renderer = renderer_of(pixels, sensor, options);
  return is_true(renderer, dense_counts(pixels, sensor), sensor);
}

}  // namespace tactile::test
