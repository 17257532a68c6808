#pragma once

#include <vector>

#include "tactile/robot/robot_log.hpp"

namespace tactile {

/// Sets `tcp_speed` to how `tcp_pose` changes, where a log has no speeds: at each row the slope of the parabola through the rows
/// within 8 ms of it (least squares), and one row at least to either side, on their own times, lost rows or not. At the ends,
/// and beside a gap of more than 100 ms, the line through the row and its neighbours on the one side. The parabola keeps a
/// constant acceleration as it is; poses with noise s [m] make speeds with noise of some 90 s / second at 125 Hz, 65 at 500 Hz.
/// Turns likewise, as rotation vectors from one row to the other.
///
/// Such a speed is a mean over some time: @return the half of how long that is, as that of an even mean that spreads as far; 0
/// with less than 3 rows
microseconds set_speeds_from_poses(std::vector<RobotState>& states);

/// The same of speeds that someone else made from the poses, as the import of a bag does: those that are what the poses on either
/// side say, (x_(i+1) - x_(i-1)) / (t_(i+1) - t_(i-1)), which measured ones never are. 0 of measured ones.
microseconds smoothing_of(const std::vector<RobotState>& states);

/// Sets `tcp_pose` to the way since the first row that `tcp_speed` makes, where a log has no poses: x y z by the trapezium rule,
/// none over a gap; the turn is left 0.
void set_poses_from_speeds(std::vector<RobotState>& states);

}  // namespace tactile
