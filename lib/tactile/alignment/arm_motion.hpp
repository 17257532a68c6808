#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/alignment/vector3.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::alignment {

/// The speed of the TCP on an even grid of the robot's clock, between the first and the last row of its log.
struct ArmMotion {
  RobotTime begin{};
  microseconds step{4'000};
  std::vector<Vector3> velocity;      ///< at begin + i * step, base frame [m/s]
  std::vector<Vector3> acceleration;  ///< mean from that point to the next [m/s^2]; 0 at the last
  std::vector<bool> known;            ///< false within a gap, where the others are 0

  RobotTime time_of(std::size_t i) const { return begin + step * static_cast<std::int64_t>(i); }
};

struct ArmMotionOptions {
  microseconds step{4'000};             ///< > 0
  microseconds longest_gap{100'000};    ///< rows further apart have a gap between them, even if the log names none
  std::size_t most_points = 1U << 22U;  ///< a log that would need more is not resampled: 4.6 h at 4 ms
};

/// Straight lines between the rows. Nothing if the log has fewer than two rows or would need more points than allowed.
std::optional<ArmMotion> arm_motion(const robot::RobotLog& log, const ArmMotionOptions& options = {});

}  // namespace tactile::alignment
