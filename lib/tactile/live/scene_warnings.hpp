#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/characterise/scene.hpp"
#include "tactile/events/event.hpp"

namespace tactile::live {

/// Above which a scene of a sensor at rest is worth a warning. The limits are ours: a still scene of a real DVXplorer has 0.54
/// events per second and pixel, 116 to 131 hot pixels and no flicker (docs/numerics/scene.md). Three times that is much, and a
/// hundredth is next to nothing.
struct SceneLimits {
  double most_noise = 1.5;     ///< background [1/s per pixel]
  double least_noise = 0.005;  ///< [1/s per pixel]
  double hot_pixels = 400;     ///< their number
  double flicker_depth = 0.1;  ///< of the event rate
  double change = 2;           ///< of the background, against the median of earlier scenes, either way
  std::size_t to_compare = 3;  ///< earlier scenes
};

/// What of a scene one would regret later: a dark or covered sensor, hot pixels, a flickering light, a background that is far
/// from what it was. Sentences without their end.
/// @param earlier  scenes of the same sensor, in any order
std::vector<std::string> scene_warnings(const characterise::Scene& scene, std::span<const characterise::Scene> earlier,
                                        events::SensorSize sensor, const SceneLimits& limits = {});

}  // namespace tactile::live
