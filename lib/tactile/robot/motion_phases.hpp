#pragma once

#include <vector>

#include "tactile/robot/robot_log.hpp"

namespace tactile {

/// A stretch in which the arm moves, and what it does meanwhile.
struct MotionPhase {
  RobotTime start{};         ///< speed leaves zero: the line through its rise, down to zero
  RobotTime end{};           ///< likewise of its fall
  double peak_speed = 0;     ///< [m/s]
  double height_change = 0;  ///< [m] along the base's z, up is positive
};

struct MotionPhaseOptions {
  double slowest = 0.004;         ///< [m/s] the arm rests below this and below five standard deviations of its noise
  microseconds shortest{60'000};  ///< shorter ones are noise
};

/// Every stretch of motion, by time, from the magnitude of the TCP's linear speed. A row in every 8 ms (or 2 ms) is enough for a
/// start to about a millisecond, since the rise of a trapezoidal profile is a straight line. Source: UR's RTDE guide,
/// `actual_TCP_speed`.
std::vector<MotionPhase> motion_phases(const RobotLog& log, const MotionPhaseOptions& options = {});

}  // namespace tactile
