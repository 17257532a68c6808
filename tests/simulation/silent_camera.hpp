#pragma once

#include "tactile/simulation/event_camera_options.hpp"

namespace tactile::test {

/// A still skin without markers, and pixels without noise.
inline simulation::EventCameraOptions silent_camera() {
  simulation::EventCameraOptions options;
  options.size = {64, 48};
  options.leak_hz = options.shot_hz = 0;
  options.hot_pixels = options.dead_pixels = 0;
  return options;
}

}  // namespace tactile::test
