#pragma once

#include <vector>

#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {

/// Sets `tcp_speed` from `tcp_pose`, for a log without speeds: at each row the gradient of the parabola of least squares through
/// the rows within 8 ms of it, and at least one row on either side, at their own times. At the ends, and next to a gap of more
/// than 100 ms, the line through the row and its neighbours on one side. The parabola is exact for a constant acceleration; poses
/// with noise s [m] give speeds with noise of about 90 s / second at 125 Hz, 65 at 500 Hz. The same for rotations, as rotation
/// vectors from row to row.
///
/// Such a speed is a mean over some time. @return half the length of an even mean with the same spread; 0 with fewer than 3 rows
microseconds set_speeds_from_poses(std::vector<RobotState>& states);

/// The same for speeds that already follow from the poses, as in an imported bag: those that equal
/// (x_(i+1) - x_(i-1)) / (t_(i+1) - t_(i-1)), which measured ones do not. 0 for measured ones.
microseconds smoothing_of(const std::vector<RobotState>& states);

/// Sets `tcp_pose` to the integral of `tcp_speed` since the first row, for a log without poses: x y z by the trapezoidal rule,
/// nothing over a gap; the rotation stays 0.
void set_poses_from_speeds(std::vector<RobotState>& states);

}  // namespace tactile::robot
