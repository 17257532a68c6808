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

namespace tactile {

/// No arm is so far [m, rad] or so fast [m/s, rad/s]; beyond it sums would lose their meaning.
inline constexpr double beyond_any_arm = 1e6;

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
  std::vector<RobotState> states{};            ///< ascending in time; repeated and mixed rows dropped
  std::vector<RobotGap> gaps{};                ///< among `states`: a lost connection, or no row for more than 100 ms
  std::vector<OutputChange> output_changes{};  ///< by time; what an output was before the first row is not known
  microseconds smoothed_over{0};               ///< a speed is the mean over so long to either side: it was made from poses
  std::size_t mixed_rows = 0;                  ///< were dropped, or made whole from their repetition
};

/// The columns that a log's speeds are made from. Those of the target say where the arm was sent, not where it was.
enum class RobotSpeedSource { actual_tcp_speed, actual_tcp_pose, actual_q, target_tcp_speed, target_tcp_pose, target_q };

/// `actual_TCP_speed` ..., as columns are called.
std::string_view name_of(RobotSpeedSource source);

/// Whether it says where the arm was sent alone.
constexpr bool is_target(RobotSpeedSource source) { return source >= RobotSpeedSource::target_tcp_speed; }

/// What a log file holds. A controller that starts anew counts from zero again: times before and after are of two clocks.
struct RobotLogFile {
  std::vector<RobotLog> pieces{};  ///< in the file's order, each with a state at least; none if the file has no row
  bool cut_off = false;            ///< the last row is not whole: its writer was killed. It is left out
  RobotSpeedSource speed_from = RobotSpeedSource::actual_tcp_speed;
  std::optional<ArmModel> arm{};  ///< whose kinematics made poses of joints, if any did

  const RobotLog& longest() const;     ///< the piece with the most rows, the first of such; one without rows if there is none
  std::size_t restarts() const;        ///< how often the controller's clock started anew within the file
  std::size_t rows_elsewhere() const;  ///< than in the longest piece
};

struct RobotLogOptions {
  /// Else by the rate: a UR10e sends more than 250 rows a second, unless it was asked for less, as record.py does.
  std::optional<ArmModel> arm{};
};

/// Rows a second, from the median step; 125 of a CB controller, 500 of an e-Series one. 0 with less than two rows.
double rate_hz(const RobotLog& log);

/// Packages that never came: steps of more than 1.5 periods miss one or more, gaps included.
std::uint64_t lost_packages(const RobotLog& log);

/// Reads a log as `tactile record`, UR's record.py, ur_rtde's startFileRecording or a bag's import writes it: a header row,
/// columns by RTDE's names in any order, what is not needed ignored whatever it holds; parted by commas, blanks, tabs or
/// semicolons, as the header is; rows ended by LF, CR LF, CR CR LF or CR.
///
/// Needed are `timestamp` and one of `actual_TCP_speed_0..5`, `actual_TCP_pose_0..5`, `actual_q_0..5`, or, with none of them,
/// of the same three with `target_`. Speeds come from the first of these that is there: as they are, from poses
/// (`set_speeds_from_poses`), or from the flange's poses that the joints make (`flange_pose`). Poses come from
/// `actual_TCP_pose`, `actual_q`, `target_TCP_pose`, `target_q`, or else are the way that the speeds make.
///
/// - A row with the time of the row before repeats it, and is dropped: a recorder that samples on its own clock writes some
///   packages twice.
/// - Such a recorder also mixes packages: a row's time is new and its motion still the old one's, or the other way round. Then a
///   pose or speed stands in two rows, while before and after it changes (a speed by 0.5 mm/s) and the arm moves (5 mm/s). Of the
///   two the row that fits their neighbours worse is dropped. What is mixed without a repetition is not seen; it is one period
///   off.
/// - An empty line in a log with `host_time_us` is a lost connection, in any other it means nothing.
/// - The clock has started anew where `timestamp` falls; where it and the host's time differ by more than a second in how long a
///   lost connection was away; and, without a host's time to agree, where it leaps by more than a minute.
///
/// @throws Error  naming the file, the row and the column where it cannot be read; and of record.py --binary, how to convert it
/// Sources: RTDE Python client library, record.py and csv_writer.py; ur_rtde, RTDEReceiveInterface; UR's RTDE guide.
RobotLogFile read_robot_log(const std::filesystem::path& file, const RobotLogOptions& options = {});

/// Writes the states, separated by commas, whole or not at all. `timestamp` has six decimals.
void write_robot_log(const std::filesystem::path& file, const RobotLog& log);

}  // namespace tactile
