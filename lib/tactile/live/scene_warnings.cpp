#include "tactile/live/scene_warnings.hpp"

#include <fmt/core.h>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::live {

std::vector<std::string> scene_warnings(const characterise::Scene& scene, std::span<const characterise::Scene> earlier,
                                        events::SensorSize sensor, const SceneLimits& limits) {
  std::vector<std::string> warnings;
  const double pixels = static_cast<double>(sensor.width) * sensor.height;
  const double noise = scene.background_hz / pixels;
  if (noise > limits.most_noise)
    warnings.push_back(
        fmt::format("much noise: {:.2f} events per second and pixel while nothing moves; expected {:g} at most: "
                    "more light helps",
                    noise, limits.most_noise));
  if (noise < limits.least_noise)
    warnings.push_back(
        fmt::format("nearly no noise: {:.4f} events per second and pixel; the sensor may be covered or very dark", noise));
  if (scene.hot_pixels > limits.hot_pixels)
    warnings.push_back(fmt::format("{:.0f} hot pixels; expected {:g} at most: 'tactile characterise' makes a mask of them",
                                   scene.hot_pixels, limits.hot_pixels));
  if (scene.flicker_depth > limits.flicker_depth)
    warnings.push_back(
        fmt::format("the light flickers at {:.0f} Hz, {:.0f} % of the event rate; a lamp on direct current does not",
                    scene.flicker_hz, 100 * scene.flicker_depth));
  if (earlier.size() >= limits.to_compare) {
    std::vector<double> backgrounds;
    for (const characterise::Scene& one : earlier) backgrounds.push_back(one.background_hz);
    const double usual = median(backgrounds);
    if (scene.background_hz > limits.change * usual || scene.background_hz * limits.change < usual)
      warnings.push_back(fmt::format("the background is {:.0f} kev/s, and was {:.0f}: did light or focus change?",
                                     1e-3 * scene.background_hz, 1e-3 * usual));
  }
  return warnings;
}

}  // namespace tactile::live
