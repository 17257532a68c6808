#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::events {

inline constexpr double standard_gravity = 9.80665;  ///< [m/s2]

/// A sample of the inertial sensor. Source: AEDAT4's IMU table.
struct ImuSample {
  CameraTime t;
  float temperature_c = 0;
  float acceleration_g[3] = {};     ///< x, y, z
  float angular_rate_dps[3] = {};   ///< [°/s]
  float magnetic_field_ut[3] = {};  ///< [µT]

  /// The size of the acceleration [m/s2].
  double acceleration() const {
    const auto along = [this](std::size_t axis) { return static_cast<double>(acceleration_g[axis]); };
    return standard_gravity * std::hypot(along(0), along(1), along(2));
  }
};

/// A signal at the camera's trigger input, or an internal mark. Source: AEDAT4's Trigger table.
struct Trigger {
  CameraTime t;
  std::int8_t type = 0;  ///< 0 reset of time, 1/2/3 external edge up/down/pulse, 4/5 generator's edges, 6..9 frame and exposure
};

/// One picture. `format` = 8 * (channels - 1) + depth, in OpenCV's order of depths: 0 grey, 16 BGR, 24 BGRA of 8 bits.
struct Frame {
  CameraTime t;
  CameraTime frame_start, frame_end, exposure_start, exposure_end;
  std::int8_t format = 0;
  std::int16_t width = 0, height = 0, position_x = 0, position_y = 0;
  std::vector<std::uint8_t> pixels;  ///< row by row from the top
};

}  // namespace tactile::events
