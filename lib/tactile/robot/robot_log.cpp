#include "tactile/robot/robot_log.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

constexpr std::string_view pose_name = "actual_TCP_pose_";
constexpr std::string_view speed_name = "actual_TCP_speed_";
constexpr std::string_view bits_name = "actual_digital_output_bits";
constexpr std::string_view host_time_name = "host_time_us";

constexpr microseconds longest_step = 100ms;             // single packages are lost now and then
constexpr microseconds longest_clock_disagreement = 1s;  // of robot and host over a lost connection: a reboot takes far longer

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? std::string_view() : text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// The mark that parts the header's names. Commas come first, since "a, b" has blanks too.
char separator_of(std::string_view header) {
  for (const char mark : {',', ';', '\t', ' '}) {
    if (header.find(mark) != std::string_view::npos) return mark;
  }
  return ',';
}

void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find(separator, begin);
    cells.push_back(trimmed(line.substr(begin, end == std::string_view::npos ? end : end - begin)));
    if (end == std::string_view::npos) return;
    begin = end + 1;
  }
}

/// A row of the log and what to say of a cell of it that cannot be used.
class Row {
 public:
  Row(const std::string& file, std::size_t number, const std::vector<std::string>& names,
      const std::vector<std::string_view>& cells)
      : file_(file), number_(number), names_(names), cells_(cells) {
    if (cells.size() != names.size()) {
      throw Error(fmt::format("{}: row {} has {} values; expected {}, as its header", file, number, cells.size(), names.size()));
    }
  }

  double number_at(std::size_t column) const {
    const std::optional<double> value = number_in(cells_[column]);
    if (!value || !std::isfinite(*value)) refuse(column, "a finite number");
    return *value;
  }

  /// Some writers give whole numbers as "3.0", and a single bit as "True".
  std::uint64_t bits_at(std::size_t column) const {
    const std::string_view cell = cells_[column];
    if (cell == "True" || cell == "False") return cell == "True" ? 1 : 0;
    const std::optional<double> value = number_in(cell);
    constexpr double limit = 9007199254740992.0;  // 2^53: beyond it a double skips whole numbers
    if (!value || !(*value >= 0.0 && *value <= limit) || *value != std::floor(*value))
      refuse(column, "a whole number of at least 0");
    return static_cast<std::uint64_t>(*value);
  }

  std::int64_t whole_number_at(std::size_t column, std::string_view expected) const {
    const std::optional<std::int64_t> value = whole_number_in(cells_[column]);
    if (!value) refuse(column, expected);
    return *value;
  }

  [[noreturn]] void refuse(std::size_t column, std::string_view expected) const {
    throw Error(
        fmt::format("{}: row {}, column '{}' holds '{}'; expected {}", file_, number_, names_[column], cells_[column], expected));
  }

 private:
  const std::string& file_;
  std::size_t number_;
  const std::vector<std::string>& names_;
  const std::vector<std::string_view>& cells_;
};

/// An output and the column that tells of it.
struct OutputColumn {
  std::string name;  ///< of the output, or of its first bit without the number
  std::size_t column = 0;
  int bits = 0;       ///< 0: a number
  int first_bit = 0;  ///< its number in its name
};

struct Columns {
  std::size_t time = 0;
  std::array<std::size_t, 6> pose{}, speed{};
  std::optional<std::size_t> bits, host_time;
  std::vector<OutputColumn> outputs;
};

Columns columns_of(const std::string& file, const std::vector<std::string>& names) {
  const auto find = [&](const std::string& name) -> std::optional<std::size_t> {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    if (std::find(found + 1, names.end(), name) != names.end()) {
      throw Error(fmt::format("{}: two columns are called '{}'; expected one", file, name));
    }
    return static_cast<std::size_t>(found - names.begin());
  };
  const auto need = [&](const std::string& name) {
    const auto column = find(name);
    if (!column) throw Error(fmt::format("{}: no column '{}'; expected a header row with RTDE's names", file, name));
    return *column;
  };
  Columns columns;
  columns.time = need("timestamp");
  for (std::size_t i = 0; i < 6; ++i) {
    columns.pose[i] = need(fmt::format("{}{}", pose_name, i));
    columns.speed[i] = need(fmt::format("{}{}", speed_name, i));
  }
  columns.bits = find(std::string(bits_name));
  columns.host_time = find(std::string(host_time_name));
  const auto add_output = [&](const std::string& column, std::string name, int bits, int first_bit) {
    if (const auto found = find(column))
      columns.outputs.push_back({.name = std::move(name), .column = *found, .bits = bits, .first_bit = first_bit});
  };
  add_output(std::string(bits_name), "digital output ", 64, 0);
  add_output("output_bit_registers0_to_31", "output_bit_register_", 32, 0);
  add_output("output_bit_registers32_to_63", "output_bit_register_", 32, 32);
  for (int i = 64; i < 128; ++i) add_output(fmt::format("output_bit_register_{}", i), "output_bit_register_", 1, i);
  for (int i = 0; i < 48; ++i) {
    const std::string name = fmt::format("output_int_register_{}", i);
    add_output(name, name, 0, 0);
  }
  return columns;
}

RobotState state_in(const Row& row, const Columns& columns) {
  RobotState state;
  const double seconds = row.number_at(columns.time);
  if (std::abs(seconds) > 1e12) row.refuse(columns.time, "controller seconds");
  state.t = RobotTime{microseconds{std::llround(seconds * 1e6)}};
  for (std::size_t i = 0; i < 6; ++i) {
    state.tcp_pose[i] = row.number_at(columns.pose[i]);
    state.tcp_speed[i] = row.number_at(columns.speed[i]);
  }
  if (columns.bits) state.digital_output_bits = row.bits_at(*columns.bits);
  if (columns.host_time) state.host_time = HostTime{microseconds{row.whole_number_at(*columns.host_time, "whole microseconds")}};
  return state;
}

std::vector<std::int64_t> outputs_in(const Row& row, const Columns& columns) {
  std::vector<std::int64_t> values;
  for (const OutputColumn& output : columns.outputs) {
    values.push_back(output.bits == 0 ? row.whole_number_at(output.column, "a whole number")
                                      : static_cast<std::int64_t>(row.bits_at(output.column)));
  }
  return values;
}

/// Sorts the rows of a log into the pieces of its clocks.
class Pieces {
 public:
  void connection_lost() { lost_ = true; }

  /// @return whether the row counts; else it repeats the one before
  bool add(const RobotState& state) {
    const bool was_lost = std::exchange(lost_, false);
    if (pieces_.empty() || starts_anew(state, was_lost)) {
      pieces_.emplace_back().states.push_back(state);
      outputs_.clear();
      return true;
    }
    RobotLog& piece = pieces_.back();
    const RobotState& before = piece.states.back();
    if (state.t == before.t) {  // a recorder that samples on its own clock writes some packages twice
      lost_ = was_lost;
      return false;
    }
    if (was_lost || state.t - before.t > longest_step) piece.gaps.push_back({before.t, state.t});
    piece.states.push_back(state);
    return true;
  }

  /// What the outputs are in the row that was added last.
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

 private:
  bool starts_anew(const RobotState& state, bool was_lost) const {
    const RobotState& before = pieces_.back().states.back();
    return state.t < before.t || (was_lost && clocks_disagree(before, state));
  }

  static bool clocks_disagree(const RobotState& before, const RobotState& after) {
    if (!before.host_time || !after.host_time) return false;
    const std::int64_t host = saturating_subtract(us_of(*after.host_time), us_of(*before.host_time));
    const std::int64_t difference = saturating_subtract(host, (after.t - before.t).count());
    return difference > longest_clock_disagreement.count() || difference < -longest_clock_disagreement.count();
  }

  std::vector<RobotLog> pieces_;
  std::vector<std::int64_t> outputs_;  ///< in the last row
  bool lost_ = false;
};

}  // namespace

std::string_view name_of(RobotSpeedSource source) {
  switch (source) {
    case RobotSpeedSource::actual_tcp_speed:
      return "actual_TCP_speed";
    case RobotSpeedSource::actual_tcp_pose:
      return "actual_TCP_pose";
    case RobotSpeedSource::actual_q:
      return "actual_q";
  }
  return "";
}

const RobotLog& RobotLogFile::longest() const {
  static const RobotLog none;
  const auto found = std::max_element(pieces.begin(), pieces.end(),
                                      [](const RobotLog& a, const RobotLog& b) { return a.states.size() < b.states.size(); });
  return found == pieces.end() ? none : *found;
}

std::size_t RobotLogFile::restarts() const { return pieces.empty() ? 0 : pieces.size() - 1; }

std::size_t RobotLogFile::rows_elsewhere() const {
  std::size_t rows = 0;
  for (const RobotLog& piece : pieces) rows += piece.states.size();
  return rows - longest().states.size();
}

RobotLogFile read_robot_log(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path)) throw Error(file + ": cannot be read; expected a robot log");

  Pieces pieces;
  bool cut_off = false;
  std::string line;
  std::vector<std::string> names;
  std::vector<std::string_view> cells;
  char separator = ',';
  Columns columns;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    const bool is_ended = !in.eof();
    std::string_view text = line;
    if (number == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the mark that some editors put before UTF-8
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
    if (trimmed(text).empty()) {
      if (columns.host_time) pieces.connection_lost();
      continue;
    }
    if (names.empty()) {
      separator = separator_of(text);
      split(text, separator, cells);
      names.assign(cells.begin(), cells.end());
      columns = columns_of(file, names);
      continue;
    }
    split(text, separator, cells);
    // Whoever writes host times ends every row, so that one without its end was cut off, be it in the middle of its last number.
    if (!is_ended && columns.host_time) {
      cut_off = true;
      break;
    }
    try {
      const Row row(file, number, names, cells);
      const RobotState state = state_in(row, columns);
      const std::vector<std::int64_t> outputs = outputs_in(row, columns);
      if (pieces.add(state)) pieces.add_outputs(columns.outputs, outputs);
    } catch (const Error&) {
      if (is_ended) throw;
      cut_off = true;
    }
  }
  if (in.bad()) throw Error(file + ": reading it failed half-way; expected a readable file");
  if (names.empty()) throw Error(file + ": is empty; expected a header row with RTDE's names");
  return {.pieces = pieces.take(), .cut_off = cut_off};
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

}  // namespace tactile
