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
  std::optional<HostTime> host_time;                 ///< `host_time_us`: when the row came to the host
};

/// Nothing is known of the robot between the two.
struct RobotGap {
  RobotTime last_before{};
  RobotTime first_after{};
};

/// What a log holds. A controller that starts anew counts from zero again: times before and after are of two clocks, and only the
/// piece with the most rows is kept.
struct RobotLog {
  std::vector<RobotState> states;  ///< ascending in time, of one clock; repeated rows dropped
  std::vector<RobotGap> gaps;      ///< among `states`: a lost connection, or no row for more than 100 ms
  std::size_t restarts = 0;        ///< how often the controller's clock started anew within the log
  std::size_t left_out_rows = 0;   ///< rows of the other clocks
  bool cut_off = false;            ///< the last row is not whole: its writer was killed. It is left out
};

/// Reads a log with a header row and columns by name; needs `timestamp`, `actual_TCP_pose_0..5` and `actual_TCP_speed_0..5`.
/// Separated by commas, spaces, tabs or semicolons, as its header is. An empty line in a log with `host_time_us` is a lost
/// connection, in any other it means nothing. The clock has started anew where `timestamp` falls, and where it and the host's
/// time differ by more than a second in how long a lost connection was away.
/// @throws Error  naming the file, the row and the column where it cannot be read
RobotLog read_robot_log(const std::filesystem::path& file);

/// Writes the states, separated by commas, whole or not at all. `timestamp` has six decimals.
void write_robot_log(const std::filesystem::path& file, const RobotLog& log);

}  // namespace tactile
