#pragma once

#include <span>
#include <vector>

#include "tactile/alignment/vector3.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::alignment {

/// The camera's own motion by its IMU, in the sensor's axes.
struct ImuMotion {
  std::vector<CameraTime> t;          ///< ascending
  std::vector<Vector3> acceleration;  ///< without gravity and bias [m/s^2]
  double noise_m_s2 = 0;              ///< standard deviation of a sample at rest, each axis

  double seconds(std::size_t i) const { return 1e-6 * static_cast<double>(between(t.front(), t[i]).count()); }
};

/// Takes off gravity and bias: the running median over two seconds of each axis. An arm speeds up or brakes for a fraction of a
/// second, which does not move that median. Samples out of order are left out.
ImuMotion imu_motion(std::span<const events::ImuSample> samples);

}  // namespace tactile::alignment
