#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile {

/// One row of a robot log, in RTDE's terms.
struct RobotState {
  RobotTime t;                                       ///< `timestamp`, controller seconds, rounded to microseconds
  std::array<double, 6> tcp_pose{};                  ///< `actual_TCP_pose`: x y z [m], rotation vector [rad], base frame
  std::array<double, 6> tcp_speed{};                 ///< `actual_TCP_speed`: [m/s], [rad/s]
  std::optional<std::uint64_t> digital_output_bits;  ///< `actual_digital_output_bits`
};

struct RobotLog {
  std::vector<RobotState> states;  ///< ascending in time; repeated rows dropped
};

/// Reads a log with a header row and columns by name; needs `timestamp`, `actual_TCP_pose_0..5` and `actual_TCP_speed_0..5`.
/// Separated by commas, spaces, tabs or semicolons, as its header is.
/// @throws Error  naming the file, the row and the column where it cannot be read
RobotLog read_robot_log(const std::filesystem::path& file);

/// Writes the same, separated by commas, whole or not at all. `timestamp` has six decimals.
void write_robot_log(const std::filesystem::path& file, const RobotLog& log);

}  // namespace tactile
