#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/robot/arm_kinematics.hpp"

namespace tactile::robot {

/// No arm is so far [m, rad] or so fast [m/s, rad/s]; beyond it sums would overflow their precision.
inline constexpr double beyond_any_arm = 1e6;

/// One row of a robot log, in RTDE's terms.
struct RobotState {
  RobotTime t;                                       ///< `timestamp`, controller seconds, rounded to microseconds
  std::array<double, 6> tcp_pose{};                  ///< `actual_TCP_pose`: x y z [m], rotation vector [rad], base frame
  std::array<double, 6> tcp_speed{};                 ///< `actual_TCP_speed`: [m/s], [rad/s]
  std::optional<std::uint64_t> digital_output_bits;  ///< `actual_digital_output_bits`
  std::optional<HostTime> host_time;                 ///< `host_time_us`: when the row arrived at the host
};

/// A time in which nothing is known of the robot.
struct RobotGap {
  RobotTime last_before{};
  RobotTime first_after{};
};

/// The robot's program set an output: a command to a stage or gripper, or a mark.
struct OutputChange {
  std::string output;           ///< "digital output 0" ..., "output_bit_register_0" ..., "output_int_register_0" ...
  std::int64_t from = 0;        ///< a bit is 0 or 1
  std::int64_t to = 0;          ///< a bit is 0 or 1
  RobotTime last_before{}, at;  ///< the last row before the change, and the first row with the new value
};

/// The rows of one clock: those of a log between two starts of the controller.
struct RobotLog {
  std::vector<RobotState> states{};            ///< ascending in time; repeated and mixed rows dropped
  std::vector<RobotGap> gaps{};                ///< among `states`: a lost connection, or no row for more than 100 ms
  std::vector<OutputChange> output_changes{};  ///< by time; outputs before the first row are not known
  std::size_t mixed_rows = 0;                  ///< dropped, or completed from their repetition
};

/// The columns that a log's speeds follow from. Those of the target are the commanded motion, not the actual one.
enum class RobotSpeedSource { actual_tcp_speed, actual_tcp_pose, actual_q, target_tcp_speed, target_tcp_pose, target_q };

/// `actual_TCP_speed` ..., the names of the columns.
std::string_view name_of(RobotSpeedSource source);

/// Whether it is the commanded motion only.
constexpr bool is_target(RobotSpeedSource source) { return source >= RobotSpeedSource::target_tcp_speed; }

/// The contents of a log file. A controller that restarts counts from zero again: times before and after are of two clocks.
struct RobotLogFile {
  std::vector<RobotLog> pieces{};  ///< in the file's order, each with at least one state; none if the file has no row
  bool cut_off = false;            ///< the last row is not whole, because its writer was killed. It is left out
  RobotSpeedSource speed_from = RobotSpeedSource::actual_tcp_speed;
  std::optional<ArmModel> arm{};  ///< whose kinematics gave poses from joints, if it was needed

  const RobotLog& longest() const;     ///< the first piece with the most rows; an empty one if there is none
  std::size_t restarts() const;        ///< how often the controller's clock restarted within the file
  std::size_t rows_elsewhere() const;  ///< outside the longest piece
};

/// The names in a list such as "timestamp,actual_q*6,-*18": `*6` stands for six columns, actual_q_0 to actual_q_5, and `-` for
/// one to skip, whose name is empty. @throws Error  if a part of it is no name
std::vector<std::string> column_names(std::string_view list);

struct RobotLogOptions {
  /// Nothing: by the rate. A UR10e sends more than 250 rows a second, unless a client asks for less, as record.py does.
  std::optional<ArmModel> arm{};
  /// Names of the columns of a log without header row, as `column_names` takes them.
  std::string columns{};
};

/// Rows per second, from the median step; 125 of a CB controller, 500 of an e-Series one. 0 with fewer than two rows.
double rate_hz(const RobotLog& log);

/// Lost packages: steps of more than 1.5 periods miss one or more, gaps included.
std::uint64_t lost_packages(const RobotLog& log);

/// Reads a log of `tactile record`, UR's record.py, ur_rtde's startFileRecording or a bag's import: a header row, or
/// `options.columns`, and columns by RTDE's names in any order. Other columns are ignored. Cells are separated by commas, blanks,
/// tabs or semicolons, as in the header; rows end with LF, CR LF, CR CR LF or CR.
///
/// Needed are `timestamp` and one of `actual_TCP_speed_0..5`, `actual_TCP_pose_0..5`, `actual_q_0..5`, or, with none of them,
/// of the same three with `target_`. Speeds come from the first of these that exists: directly, from poses
/// (`set_speeds_from_poses`), or from the flange's poses by the joints (`flange_pose`). Poses come from `actual_TCP_pose`,
/// `actual_q`, `target_TCP_pose`, `target_q`, or else are the integral of the speeds.
///
/// - A row with the time of the row before repeats it, and is dropped: a recorder that samples on its own clock writes some
///   packages twice.
/// - Such a recorder also mixes packages: a row's time is new and its motion is that of the row before, or the reverse. Such rows
///   are dropped (`drop_mixed_rows`). Rows that are mixed without a repetition are not found; they are one period off.
/// - An empty line in a log with `host_time_us` is a lost connection; in any other log it has no meaning.
/// - The clock has restarted where `timestamp` decreases; where `timestamp` and host time disagree by more than a second about
/// the
///   length of a lost connection; and, without host times, where it leaps by more than a minute.
///
/// @throws Error  naming the file, the row and the column that cannot be read; for record.py --binary, how to convert the file;
/// if the units are others (`other_units`); if times were rounded when the log was written: half of the rows or more repeat the
/// time of the row before, and the motion continues, or all times are whole seconds Sources: RTDE Python client library,
/// record.py and csv_writer.py; ur_rtde, RTDEReceiveInterface; UR's RTDE guide.
RobotLogFile read_robot_log(const std::filesystem::path& file, const RobotLogOptions& options = {});

/// Writes the states, separated by commas, whole or not at all. `timestamp` has six decimals.
void write_robot_log(const std::filesystem::path& file, const RobotLog& log);

}  // namespace tactile::robot
