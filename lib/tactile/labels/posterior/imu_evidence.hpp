#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::labels {

/// How well the camera's accelerations fit the arm's in its log, for an offset of the robot's clock.
///
/// Both are means over bins of 4 ms, the arm's along the direction of most of its acceleration. Each axis of the IMU is fitted by
/// it and a constant, because the camera may be mounted in any direction. With the correlation r of an axis,
///
///   ln p(IMU | offset) = -n / 2 * sum over axes of ln(1 - r^2)
///
/// n is the number of independent values: a twentieth of the bins, because what the fit leaves is partly the ringing of the
/// mount, with periods of up to 80 ms.
class ImuEvidence {
 public:
  ImuEvidence(std::span<const events::ImuSample> samples, const alignment::ArmMotion& arm);

  bool empty() const { return imu_.empty(); }
  double of(std::int64_t offset_us) const;

 private:
  std::int64_t begin_us_ = 0;            ///< camera time of the first bin's middle
  std::vector<alignment::Vector3> imu_;  ///< [g], less the mean
  std::int64_t arm_begin_us_ = 0, arm_step_us_ = 0;
  std::vector<double> arm_;  ///< [m/s^2]
  double independent_ = 0;
};

}  // namespace tactile::labels
