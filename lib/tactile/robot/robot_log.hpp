#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
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

/// The robot's program set an output: the command of a stage or gripper, or a mark of its own.
struct OutputChange {
  std::string output;     ///< "digital output 0" ..., "output_bit_register_0" ..., "output_int_register_0" ...
  std::int64_t from = 0;  ///< a bit is 0 or 1
  std::int64_t to = 0;    ///< likewise
  RobotTime last_before{},
      at;  ///< the last row before, the first row with the new value: it changed after the one, not after the other
};

/// What one clock has counted: the rows of a log between two starts of the controller.
struct RobotLog {
  std::vector<RobotState> states;            ///< ascending in time; repeated rows dropped
  std::vector<RobotGap> gaps;                ///< among `states`: a lost connection, or no row for more than 100 ms
  std::vector<OutputChange> output_changes;  ///< by time; what an output was before the first row is not known
};

/// What a log's speeds are made from.
enum class RobotSpeedSource { actual_tcp_speed, actual_tcp_pose, actual_q };

/// `actual_TCP_speed` ..., as columns are called.
std::string_view name_of(RobotSpeedSource source);

/// What a log file holds. A controller that starts anew counts from zero again: times before and after are of two clocks.
struct RobotLogFile {
  std::vector<RobotLog> pieces;  ///< in the file's order, each with a state at least; none if the file has no row
  bool cut_off = false;          ///< the last row is not whole: its writer was killed. It is left out
  RobotSpeedSource speed_from = RobotSpeedSource::actual_tcp_speed;

  const RobotLog& longest() const;     ///< the piece with the most rows, the first of such; one without rows if there is none
  std::size_t restarts() const;        ///< how often the controller's clock started anew within the file
  std::size_t rows_elsewhere() const;  ///< than in the longest piece
};

/// Reads a log with a header row and columns by name; needs `timestamp`, `actual_TCP_pose_0..5` and `actual_TCP_speed_0..5`.
/// Separated by commas, spaces, tabs or semicolons, as its header is. An empty line in a log with `host_time_us` is a lost
/// connection, in any other it means nothing. The clock has started anew where `timestamp` falls, and where it and the host's
/// time differ by more than a second in how long a lost connection was away.
/// @throws Error  naming the file, the row and the column where it cannot be read
RobotLogFile read_robot_log(const std::filesystem::path& file);

/// Writes the states, separated by commas, whole or not at all. `timestamp` has six decimals.
void write_robot_log(const std::filesystem::path& file, const RobotLog& log);

}  // namespace tactile
