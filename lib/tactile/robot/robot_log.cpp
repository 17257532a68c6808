#include "tactile/robot/robot_log.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/log_units.hpp"
#include "tactile/robot/mixed_rows.hpp"
#include "tactile/robot/pose_speeds.hpp"

namespace tactile::robot {
namespace {

constexpr std::string_view pose_name = "actual_TCP_pose_";
constexpr std::string_view speed_name = "actual_TCP_speed_";
constexpr std::string_view bits_name = "actual_digital_output_bits";
constexpr std::string_view host_time_name = "host_time_us";

constexpr microseconds longest_clock_disagreement = 1s;  // of robot and host about a lost connection: a reboot takes far longer
constexpr microseconds longest_leap = 60s;               // no recorder of a run pauses longer
constexpr double fastest_cb_rate_hz = 250.0;             // CB controllers send 125 rows a second, e-Series ones up to 500

using Six = std::array<std::size_t, 6>;

/// An output and its column.
struct OutputColumn {
  std::string name;  ///< of the output, or of its first bit without the number
  std::size_t column = 0;
  int bits = 0;       ///< 0: a number
  int first_bit = 0;  ///< its number in its name
};

struct Columns {
  std::size_t time = 0;
  std::optional<Six> speed, pose;
  RobotSpeedSource speed_from = RobotSpeedSource::actual_tcp_speed, pose_from = RobotSpeedSource::actual_tcp_pose;
  std::optional<std::size_t> bits, host_time;
  std::vector<OutputColumn> outputs;

  bool pose_is_joints() const { return pose_from == RobotSpeedSource::actual_q || pose_from == RobotSpeedSource::target_q; }
};

/// All six columns of a vector, or none. @throws Error  if some are missing
std::optional<Six> vector_columns(const TableFile& table, RobotSpeedSource source) {
  Six columns{};
  std::array<std::string, 6> names;
  std::size_t found = 0;
  std::string missing;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string name = fmt::format("{}_{}", name_of(source), i);
    const std::optional<std::size_t> column = table.find(name);
    if (column) {
      columns[i] = *column;
      ++found;
    } else if (missing.empty()) {
      missing = name;
    }
  }
  if (found == 0) return std::nullopt;
  if (found < 6)
    throw Error(fmt::format("{}: no column '{}'; expected all six of {}, or none", table.file(), missing, name_of(source)));
  return columns;
}

void find_motion(const TableFile& table, Columns& columns) {
  using Source = RobotSpeedSource;
  const auto find = [&](Source source) { return vector_columns(table, source); };
  const auto take_pose = [&](Source pose, Source joints) {
    for (const Source source : {pose, joints}) {
      if (columns.pose) return;
      columns.pose = find(source);
      if (columns.pose) columns.pose_from = source;
    }
  };
  columns.speed = find(Source::actual_tcp_speed);
  take_pose(Source::actual_tcp_pose, Source::actual_q);
  const bool has_actual = columns.speed || columns.pose;
  if (!columns.speed) columns.speed_from = columns.pose_from;
  take_pose(Source::target_tcp_pose, Source::target_q);
  if (has_actual) return;
  columns.speed = find(Source::target_tcp_speed);
  if (!columns.speed && !columns.pose) {
    throw Error(
        fmt::format("{}: no column '{}0'; expected those of actual_TCP_speed, actual_TCP_pose or actual_q (or target_...), by "
                    "RTDE's names with _0 to _5 after them",
                    table.file(), speed_name));
  }
  columns.speed_from = columns.speed ? Source::target_tcp_speed : columns.pose_from;
}

Columns columns_of(const TableFile& table) {
  Columns columns;
  const auto time = table.find("timestamp");
  if (!time)
    throw Error(table.file() +
                ": no column 'timestamp'; expected a header row with RTDE's names, or --robot-columns with a name or - "
                "for each column");
  columns.time = *time;
  find_motion(table, columns);
  columns.bits = table.find(bits_name);
  columns.host_time = table.find(host_time_name);
  const auto add_output = [&](std::string_view column, std::string name, int bits, int first_bit) {
    if (const auto found = table.find(column))
      columns.outputs.push_back({.name = std::move(name), .column = *found, .bits = bits, .first_bit = first_bit});
  };
  add_output(bits_name, "digital output ", 64, 0);
  add_output("output_bit_registers0_to_31", "output_bit_register_", 32, 0);
  add_output("output_bit_registers32_to_63", "output_bit_register_", 32, 32);
  for (int i = 64; i < 128; ++i) add_output(fmt::format("output_bit_register_{}", i), "output_bit_register_", 1, i);
  for (int i = 0; i < 48; ++i) {
    const std::string name = fmt::format("output_int_register_{}", i);
    add_output(name, name, 0, 0);
  }
  return columns;
}

/// record.py --binary writes the types of the columns as its second row, then bytes. @return how struct reads them; empty if the
/// row is another
std::string binary_format(const TableFile& table) {
  constexpr std::array<std::pair<std::string_view, char>, 8> codes{{{"DOUBLE", 'd'},
                                                                    {"INT32", 'i'},
                                                                    {"UINT32", 'I'},
                                                                    {"UINT64", 'Q'},
                                                                    {"INT64", 'q'},
                                                                    {"BOOL", '?'},
                                                                    {"UINT8", 'B'},
                                                                    {"UINT16", 'H'}}};
  if (table.is_blank()) return {};
  std::string format = ">";
  char last = 0;
  std::size_t count = 0;
  const auto put = [&] {
    if (count > 0) format += (count > 1 ? std::to_string(count) : "") + last;
  };
  for (const std::string_view cell : table.cells()) {
    const auto found = std::find_if(codes.begin(), codes.end(), [&](const auto& code) { return code.first == cell; });
    if (found == codes.end()) return {};
    if (found->second != last) {
      put();
      last = found->second;
      count = 0;
    }
    ++count;
  }
  put();
  return format;
}

void refuse_binary(const TableFile& table) {
  const std::string format = binary_format(table);
  if (format.empty()) return;
  throw Error(
      fmt::format("{}: row {} names types, so bytes follow, as record.py --binary writes them; expected text: record without "
                  "--binary, or write row 1 and then, as text, what Python's struct.iter_unpack('{}', rest) gives",
                  table.file(), table.number(), format));
}

RobotState state_in(const TableFile& table, const Columns& columns) {
  RobotState state;
  const double seconds = table.number_at(columns.time);
  if (std::abs(seconds) > 1e12) table.refuse(columns.time, "seconds; divide milliseconds by 1000, microseconds by 1000000");
  state.t = RobotTime{microseconds{std::llround(seconds * 1e6)}};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto number_at = [&](std::size_t column) {
      const double value = table.number_at(column);
      if (std::abs(value) > beyond_any_arm) table.refuse(column, "metres and radians");
      return value;
    };
    if (columns.pose) state.tcp_pose[i] = number_at((*columns.pose)[i]);
    if (columns.speed) state.tcp_speed[i] = number_at((*columns.speed)[i]);
  }
  if (columns.bits) state.digital_output_bits = table.bits_at(*columns.bits);
  if (columns.host_time) {
    const std::int64_t us = table.whole_number_at(*columns.host_time);
    state.host_time = HostTime{microseconds{us}};
  }
  return state;
}

std::vector<std::int64_t> outputs_in(const TableFile& table, const Columns& columns) {
  std::vector<std::int64_t> values;
  for (const OutputColumn& output : columns.outputs) {
    values.push_back(output.bits == 0 ? table.whole_number_at(output.column)
                                      : static_cast<std::int64_t>(table.bits_at(output.column)));
  }
  return values;
}

bool same_motion(const RobotState& a, const RobotState& b) { return a.tcp_pose == b.tcp_pose && a.tcp_speed == b.tcp_speed; }

/// Sorts the rows of a log into the pieces of its clocks.
class Pieces {
 public:
  void connection_lost() { lost_ = true; }

  /// @return false if the row repeats the one before
  bool add(const RobotState& state) {
    ++rows_;
    if (us_of(state.t) % 1'000'000 != 0) whole_seconds_ = false;
    const bool was_lost = std::exchange(lost_, false);
    if (pieces_.empty() || starts_again(state, was_lost)) {
      pieces_.emplace_back().states.push_back(state);
      outputs_.clear();
      return true;
    }
    RobotLog& piece = pieces_.back();
    const RobotState& before = piece.states.back();
    if (state.t == before.t) {
      lost_ = was_lost;
      ++repeated_rows_;
      if (!same_motion(state, before)) ++moved_rows_;
      repair_by_repetition(piece, state);
      return false;
    }
    if (was_lost || state.t - before.t > longest_row_step) piece.gaps.push_back({before.t, state.t});
    piece.states.push_back(state);
    return true;
  }

  /// The outputs in the last row that was added.
  void add_outputs(const std::vector<OutputColumn>& columns, const std::vector<std::int64_t>& values) {
    RobotLog& piece = pieces_.back();
    for (std::size_t i = 0; i < outputs_.size() && i < values.size(); ++i) {
      if (values[i] == outputs_[i]) continue;
      const RobotTime at = piece.states.back().t, last_before = piece.states[piece.states.size() - 2].t;
      const OutputColumn& column = columns[i];
      if (column.bits == 0) {
        piece.output_changes.push_back({column.name, outputs_[i], values[i], last_before, at});
        continue;
      }
      const auto changed = static_cast<std::uint64_t>(values[i]) ^ static_cast<std::uint64_t>(outputs_[i]);
      for (int bit = 0; bit < column.bits; ++bit) {
        if ((changed >> bit & 1U) == 0) continue;
        const auto is = static_cast<std::int64_t>(static_cast<std::uint64_t>(values[i]) >> bit & 1U);
        piece.output_changes.push_back({fmt::format("{}{}", column.name, column.first_bit + bit), 1 - is, is, last_before, at});
      }
    }
    outputs_ = values;
  }

  std::vector<RobotLog> take() { return std::move(pieces_); }

  /// @throws Error  if the times were rounded. A recorder that is faster than the controller repeats times too, with the motion
  void refuse_rounded_times(const std::string& file) const {
    constexpr std::size_t fewest_rows = 10;
    if (rows_ < fewest_rows || 2 * repeated_rows_ < rows_ || (!whole_seconds_ && 2 * moved_rows_ < repeated_rows_)) return;
    throw Error(fmt::format(
        "{}: {} of {} rows have the time of the row before{}: the times were rounded{} when the log was written, "
        "so the time of a row is not known; expected times as the controller gives them, such as 83.456",
        file, repeated_rows_, rows_, moved_rows_ > 0 ? ", and another motion" : "", whole_seconds_ ? " to whole seconds" : ""));
  }

 private:
  bool starts_again(const RobotState& state, bool was_lost) const {
    const RobotState& before = pieces_.back().states.back();
    if (state.t < before.t) return true;
    const bool leaps = state.t - before.t > longest_leap;
    if (!before.host_time || !state.host_time) return leaps;
    return (was_lost || leaps) && clocks_disagree(before, state);
  }

  static bool clocks_disagree(const RobotState& before, const RobotState& after) {
    const std::int64_t host = saturating_subtract(us_of(*after.host_time), us_of(*before.host_time));
    const std::int64_t difference = saturating_subtract(host, (after.t - before.t).count());
    return difference > longest_clock_disagreement.count() || difference < -longest_clock_disagreement.count();
  }

  /// A row that was sampled too early has its package's time and the motion of the one before; its repetition is whole.
  static void repair_by_repetition(RobotLog& piece, const RobotState& again) {
    const std::size_t n = piece.states.size();
    if (n < 3) return;
    RobotState& last = piece.states[n - 1];
    const bool is_late = same_motion(last, piece.states[n - 2]) && !same_motion(piece.states[n - 2], piece.states[n - 3]);
    if (!is_late || same_motion(last, again)) return;
    last.tcp_pose = again.tcp_pose;
    last.tcp_speed = again.tcp_speed;
    ++piece.mixed_rows;
  }

  std::vector<RobotLog> pieces_;
  std::vector<std::int64_t> outputs_;  ///< in the last row
  bool lost_ = false;
  std::size_t rows_ = 0, repeated_rows_ = 0, moved_rows_ = 0;  ///< with the time of the row before, and those with another motion
  bool whole_seconds_ = true;                                  ///< all times so far
};

/// Makes what the columns lack: poses from joints, speeds from poses.
void complete(RobotLogFile& file, const Columns& columns, const RobotLogOptions& options) {
  for (RobotLog& piece : file.pieces)
    drop_mixed_rows(piece, columns.speed.has_value(), columns.pose && !columns.pose_is_joints());
  if (columns.pose_is_joints() && !file.pieces.empty())
    file.arm = options.arm.value_or(rate_hz(file.longest()) > fastest_cb_rate_hz ? ArmModel::ur10e : ArmModel::ur10);
  for (RobotLog& piece : file.pieces) {
    for (RobotState& state : piece.states) {
      if (file.arm) state.tcp_pose = flange_pose(*file.arm, state.tcp_pose);
    }
    if (!columns.speed) set_speeds_from_poses(piece.states);
    if (!columns.pose) set_poses_from_speeds(piece.states);
  }
}

}  // namespace

std::string_view name_of(RobotSpeedSource source) {
  constexpr std::array<std::string_view, 6> names{"actual_TCP_speed", "actual_TCP_pose", "actual_q",
                                                  "target_TCP_speed", "target_TCP_pose", "target_q"};
  return names.at(static_cast<std::size_t>(source));
}

const RobotLog& RobotLogFile::longest() const {
  static const RobotLog none;
  const auto found = std::max_element(pieces.begin(), pieces.end(),
                                      [](const RobotLog& a, const RobotLog& b) { return a.states.size() < b.states.size(); });
  return found == pieces.end() ? none : *found;
}

double rate_hz(const RobotLog& log) {
  if (log.states.size() < 2) return 0.0;
  std::vector<std::int64_t> steps;
  steps.reserve(log.states.size() - 1);
  for (std::size_t i = 1; i < log.states.size(); ++i)
    steps.push_back(saturating_subtract(us_of(log.states[i].t), us_of(log.states[i - 1].t)));
  return 1e6 / static_cast<double>(median<std::int64_t>(steps));
}

std::uint64_t lost_packages(const RobotLog& log) {
  const double rate = rate_hz(log);
  std::uint64_t lost = 0;
  for (std::size_t i = 1; i < log.states.size(); ++i) {
    const double periods =
        1e-6 * rate * static_cast<double>(saturating_subtract(us_of(log.states[i].t), us_of(log.states[i - 1].t)));
    if (periods > 1.5) lost += static_cast<std::uint64_t>(std::llround(periods)) - 1;
  }
  return lost;
}

std::size_t RobotLogFile::restarts() const { return pieces.empty() ? 0 : pieces.size() - 1; }

std::size_t RobotLogFile::rows_elsewhere() const {
  std::size_t rows = 0;
  for (const RobotLog& piece : pieces) rows += piece.states.size();
  return rows - longest().states.size();
}

std::vector<std::string> column_names(std::string_view list) {
  constexpr std::int64_t most_columns = 1000;  // of one name
  std::vector<std::string> names;
  for (const std::string_view part : split_cells(list)) {
    const std::size_t star = part.find('*');
    const std::string_view name = trimmed(part.substr(0, star));
    const std::optional<std::int64_t> count =
        star == std::string_view::npos ? 1 : whole_number_in(trimmed(part.substr(star + 1)));
    if (name.empty() || !count || *count < 1 || *count > most_columns) {
      throw Error(
          fmt::format("{} names no column of a robot log; expected names such as timestamp, actual_q*6 for actual_q_0 "
                      "to actual_q_5, and - or -*18 for columns to skip",
                      shown_text(part)));
    }
    for (std::int64_t i = 0; i < *count; ++i) {
      const std::string suffix = star == std::string_view::npos ? "" : fmt::format("_{}", i);
      names.push_back(name == "-" ? "" : std::string(name) + suffix);
    }
  }
  return names;
}

RobotLogFile read_robot_log(const std::filesystem::path& path, const RobotLogOptions& options) {
  TableFile table(path, {.name = "a robot log",
                         .header = "RTDE's names",
                         .columns = options.columns.empty() ? std::vector<std::string>() : column_names(options.columns),
                         .columns_option = "--robot-columns"});
  const Columns columns = columns_of(table);
  Pieces pieces;
  RobotLogFile file;
  file.speed_from = columns.speed_from;
  for (bool is_first = true; table.next();) {
    if (table.is_blank()) {
      if (columns.host_time) pieces.connection_lost();
      continue;
    }
    if (std::exchange(is_first, false)) refuse_binary(table);
    // A writer of host times ends every row: one without its end was cut off, perhaps in the middle of its last number.
    if (!table.is_ended() && columns.host_time) {
      file.cut_off = true;
      break;
    }
    try {
      if (!table.is_whole()) table.refuse_row();
      const RobotState state = state_in(table, columns);
      const std::vector<std::int64_t> outputs = outputs_in(table, columns);
      if (pieces.add(state)) pieces.add_outputs(columns.outputs, outputs);
    } catch (const Error&) {
      if (table.is_ended()) throw;
      file.cut_off = true;
    }
  }
  pieces.refuse_rounded_times(table.file());
  file.pieces = pieces.take();
  const LoggedColumns logged{.pose = columns.pose ? name_of(columns.pose_from) : "",
                             .pose_is_joints = columns.pose_is_joints(),
                             .speed = columns.speed ? name_of(columns.speed_from) : ""};
  if (const std::string why = other_units(file.pieces, logged); !why.empty()) throw Error(table.file() + ": " + why);
  complete(file, columns, options);
  return file;
}

void write_robot_log(const std::filesystem::path& file, const RobotLog& log) {
  const bool has_bits =
      std::any_of(log.states.begin(), log.states.end(), [](const RobotState& s) { return s.digital_output_bits.has_value(); });
  const bool has_host_times = !log.states.empty() && std::all_of(log.states.begin(), log.states.end(),
                                                                 [](const RobotState& s) { return s.host_time.has_value(); });
  std::string text = "timestamp";
  for (const std::string_view name : {pose_name, speed_name}) {
    for (int i = 0; i < 6; ++i) text += fmt::format(",{}{}", name, i);
  }
  if (has_bits) text += fmt::format(",{}", bits_name);
  if (has_host_times) text += fmt::format(",{}", host_time_name);
  text += '\n';
  for (const RobotState& state : log.states) {
    const std::int64_t us = us_of(state.t);
    const std::uint64_t size = us < 0 ? 0 - static_cast<std::uint64_t>(us) : static_cast<std::uint64_t>(us);
    text += fmt::format("{}{}.{:06}", us < 0 ? "-" : "", size / 1'000'000, size % 1'000'000);
    for (const auto& values : {state.tcp_pose, state.tcp_speed}) {
      for (const double value : values) text += fmt::format(",{}", value);
    }
    if (has_bits) text += fmt::format(",{}", state.digital_output_bits.value_or(0));
    if (has_host_times) text += fmt::format(",{}", us_of(*state.host_time));
    text += '\n';
  }
  write_whole(file, text);
}

}  // namespace tactile::robot
