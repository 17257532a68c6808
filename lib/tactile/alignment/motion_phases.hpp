#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "tactile/alignment/speed_profile.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::alignment {

/// What the arm does: it moves up, down or neither within 45 degrees; or there and straight back, and not upwards first.
enum class MotionKind { lift, lower, sideways, tap };

std::string_view name_of(MotionKind kind);  ///< "lift" ...

/// After a motion the arm may ring for this long.
constexpr microseconds longest_ringing{350'000};

/// A motion of the arm. A motion that reverses counts as two, except a tap.
struct MotionPhase {
  MotionKind kind = MotionKind::sideways;
  RobotTime start{};  ///< the commanded speed leaves zero
  RobotTime end{};    ///< the commanded speed is zero again
  /// Standard deviation; infinite if the arm already moves where the rows begin, in the log or after a gap.
  double start_sigma_us = 0;
  double end_sigma_us = 0;          ///< standard deviation; infinite if the arm still moves where the rows end
  std::optional<RobotTime> turn{};  ///< of a tap: the far end of its path
  double turn_sigma_us = 0;
  double peak_speed = 0;                  ///< [m/s] commanded, if that is known
  double height_change = 0;               ///< [m] along the base's z, up is positive
  std::array<double, 3> displacement{};   ///< [m] base frame
  std::optional<SpeedProfile> profile{};  ///< the fitted model, in seconds from `start`; nothing where rows are too few

  bool is_whole() const;  ///< start and end are in the log
};

struct MotionPhaseOptions {
  double slowest = 0.004;         ///< [m/s] the arm rests below this and below five standard deviations of its noise
  microseconds shortest{60'000};  ///< shorter ones are noise
  microseconds longest_tap{1'000'000};
};

/// Divides a log into motions and rests, by the TCP's linear speed. @return the motions, by time
///
/// The arm rings wherever its acceleration changes. A straight line through the rise of the speed would therefore start some ms
/// late, and the ringing after a stop is as fast as a slow motion. So each stretch is fitted by command and ringing together
/// (`fit_speed_profile`), and its ringing is taken off before the next stretch is looked for. A stretch of more than 2 s, or of
/// many turns, is fitted at its two ends only. With too few rows for that, start and end are where lines through the rise and
/// fall of the speed meet zero. One row every 8 ms gives errors below a millisecond.
/// Source: UR's RTDE guide, `actual_TCP_speed`; the ringing is that of a mass on a spring.
std::vector<MotionPhase> motion_phases(const robot::RobotLog& log, const MotionPhaseOptions& options = {});

}  // namespace tactile::alignment
