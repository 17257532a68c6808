#pragma once

#include <optional>

#include "tactile/alignment/anchor_search.hpp"
#include "tactile/alignment/arm_motion.hpp"

namespace tactile::alignment {

/// The IMU as a witness. The TCP's acceleration is correlated with the measured one at every lag. The sum of squares over all
/// pairs of axes does not depend on where the sensor is mounted and how it is turned. Then each stretch of motion is fitted by
/// least squares, v(t) = a + b t + c . integral of the measured acceleration, which allows any rates of the two.
/// @return the clocks' shift [s], if it was found
std::optional<double> add_imu_anchors(AnchorSearch& search, const ArmMotion& motion);

/// Decides a match that was ambiguous, once the events give the shift: an IMU that explains no motion of the arm there
/// contradicts the log.
void add_imu_anchors_near(AnchorSearch& search, double shift_s);

}  // namespace tactile::alignment
