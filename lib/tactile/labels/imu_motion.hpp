#pragma once

#include <array>
#include <span>
#include <vector>

#include "tactile/events/other_streams.hpp"

namespace tactile {

/// What the camera's inertial sensor felt of the camera's own motion, in the sensor's axes.
struct FeltMotion {
  std::vector<CameraTime> t;                        ///< ascending
  std::vector<std::array<double, 3>> acceleration;  ///< gravity and bias removed [m/s^2]
  std::vector<std::array<double, 3>> velocity;      ///< its integral from the first sample on; it wanders off [m/s]
  std::array<double, 3> axis{};                     ///< unit vector along which most of it goes; its sign says nothing
  double noise_m_s2 = 0;                            ///< standard deviation of a sample at rest, each axis

  double seconds(std::size_t i) const { return 1e-6 * static_cast<double>(between(t.front(), t[i]).count()); }
};

/// Gravity and bias are what a camera feels that rests or moves on evenly: the running median over two seconds of each axis,
/// which the fraction of a second in which an arm speeds up or brakes does not move. Samples out of order are left out; the
/// integral passes over gaps of more than 20 ms as if nothing had been felt in them.
FeltMotion felt_motion(std::span<const ImuSample> samples);

}  // namespace tactile
