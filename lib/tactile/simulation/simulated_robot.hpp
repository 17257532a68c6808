#pragma once

#include <cstdint>

#include "tactile/core/random.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// Properties of the arm's log.
struct RobotPhysics {
  int rate_hz = 125;
  Range speed_noise_mm_s{0.2, 0.5};   ///< standard deviation, due to joint encoders
  double pose_noise_mm = 0.01;        ///< standard deviation; that of the rotation is 0.001 rad per mm
  double lost_package_share = 0.004;  ///< packages that a busy controller skips; the first is never lost
  Range after_camera_s{0.1, 0.6};     ///< time from the end of the camera to the end of the log
};

template <class Fields>
void list_fields(Fields& fields, RobotPhysics& robot) {
  fields("rate_hz", robot.rate_hz, 1, 1000);
  fields("speed_noise_mm_s", robot.speed_noise_mm_s, 0.0, 100.0);
  fields("pose_noise_mm", robot.pose_noise_mm, 0.0, 10.0);
  fields("lost_package_share", robot.lost_package_share, 0.0, 0.9);
  fields("after_camera_s", robot.after_camera_s, 0.0, 60.0);
}

struct LoggedRobot {
  robot::RobotLog log;
  std::uint64_t dropped_packages = 0;
};

/// The arm's log on its controller's clock, longer than the camera's recording at both ends. The arm is still except for the lift
/// and the taps, along the base's z axis, and its ringing. Bit 0 of the outputs follows the stage's command if the robot gives
/// it.
LoggedRobot log_robot(const RunPlan& plan, const RunClocks& clocks, const RobotPhysics& physics, Random& random);

}  // namespace tactile::simulation
