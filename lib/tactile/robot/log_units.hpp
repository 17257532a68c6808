#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {

/// The columns that the numbers of a log come from, without the `_0` to `_5` after them; empty: none.
struct LoggedColumns {
  std::string_view pose;        ///< of `tcp_pose`
  bool pose_is_joints = false;  ///< which still has the angles of the joints
  std::string_view speed;       ///< of `tcp_speed`
};

/// Why the numbers of a log are not seconds, metres, radians, m/s and rad/s, and by what to divide them. They are judged by
/// their size: rows lie at most half a second apart; along each axis a tool is within 10 m of its base, turned by at most 7 rad
/// (a turn is 6.28), as are all joints but the last, and no faster than 10 m/s and 30 rad/s. A UR10 reaches 1.3 m, and its joints
/// turn by up to 3.2 rad/s. Times, poses and joints are judged by their medians, speeds by the tenth greatest: an arm rests most
/// of the time.
/// @return empty if they may be; always with fewer than 10 rows
/// Source: Universal Robots, UR10 technical specifications.
std::string other_units(std::span<const RobotLog> pieces, const LoggedColumns& columns);

}  // namespace tactile::robot
