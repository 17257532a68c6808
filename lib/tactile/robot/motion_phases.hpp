#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "tactile/robot/robot_log.hpp"
#include "tactile/robot/speed_profile.hpp"

namespace tactile {

/// What the arm does: up, down or neither within 45 degrees; or there and back at once, which does not begin upwards.
enum class MotionKind { lift, lower, sideways, tap };

std::string_view name_of(MotionKind kind);  ///< "lift" ...

/// A stretch in which the arm moves, and what it does meanwhile. A motion that turns round is two, but for a tap.
struct MotionPhase {
  MotionKind kind = MotionKind::sideways;
  RobotTime start{};  ///< the commanded speed leaves zero
  RobotTime end{};    ///< and is back there
  /// Standard deviation; infinite if the arm already moved where the rows begin, in the log or behind a gap.
  double start_sigma_us = 0;
  double end_sigma_us = 0;          ///< likewise of moving on where they end
  std::optional<RobotTime> turn{};  ///< of a tap: the far end of its way
  double turn_sigma_us = 0;
  double peak_speed = 0;                 ///< [m/s] commanded, if that is known
  double height_change = 0;              ///< [m] along the base's z, up is positive
  std::array<double, 3> displacement{};  ///< [m] base frame
  std::optional<ArmRinging> ringing{};   ///< nothing where the rows were too few to tell it from the motion
};

struct MotionPhaseOptions {
  double slowest = 0.004;         ///< [m/s] the arm rests below this and below five standard deviations of its noise
  microseconds shortest{60'000};  ///< shorter ones are noise
  microseconds longest_tap{1'000'000};
};

/// Every stretch of motion, by time, from the TCP's linear speed.
///
/// The arm rings where its acceleration changes, at its start as after its stop: a straight line through the speed's rise would
/// start some ms late, and the tail is as fast as a slow motion. So each stretch is fitted as what was commanded and the ringing
/// that follows from it (`fit_speed_profile`), and what still rings behind it is taken away before the next is looked for. A
/// stretch of more than 2 s, or of many turns, is fitted at its two ends alone. With too few rows for that, start and end are
/// where lines through the speed's rise and fall meet zero. A row in every 8 ms (or 2 ms) is enough for less than a millisecond.
/// Source: UR's RTDE guide, `actual_TCP_speed`; the ringing is that of a mass on a spring.
std::vector<MotionPhase> motion_phases(const RobotLog& log, const MotionPhaseOptions& options = {});

/// Standard deviation of each axis of the TCP's speed at rest [m/s]: from how speeds differ that are 24 ms apart, which slow
/// changes hardly enter. 0 with less than 8 rows.
double speed_noise(const RobotLog& log);

}  // namespace tactile
