#pragma once

#include <cstdint>

#include "tactile/labels/labels.hpp"

namespace tactile::test {

/// An interval of labels whose times are certain, in ms after the camera's zero.
inline labels::LabelledInterval made_interval(Touch touch, std::int64_t start_ms, std::int64_t end_ms) {
  const auto at = [](std::int64_t ms) {
    const CameraTime t = camera_time(1000 * ms);
    return alignment::UncertainTime{t, t, t};
  };
  return {
      .id = {}, .touch = touch, .start = at(start_ms), .end = at(end_ms), .source = "events", .evidence = {}, .confirmed = false};
}

}  // namespace tactile::test
