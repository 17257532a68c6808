#include "tactile/robot/log_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"

namespace tactile::robot {
namespace {

/// The separator of the header's names. Commas come first, since "a, b" has blanks too.
char separator_of(std::string_view header) {
  for (const char mark : {',', ';', '\t', ' '}) {
    bool quoted = false;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (c == mark && !quoted) return mark;
    }
  }
  return ',';
}

}  // namespace

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

LogTable::LogTable(const std::filesystem::path& file, std::string_view columns)
    : file_(file.string()), in_(file, std::ios::binary) {
  if (!in_ || std::filesystem::is_directory(file)) throw Error(file_ + ": cannot be read; expected a robot log");
  while (read_line()) {
    std::string_view text = line_;
    constexpr std::string_view mark = "\xEF\xBB\xBF";  // some editors put it before UTF-8
    if (number_ == 1 && text.starts_with(mark)) line_.erase(0, mark.size());
    text = trimmed(line_);
    if (text.empty()) continue;
    separator_ = separator_of(text);
    split();
    take_names(columns);
    return;
  }
  throw Error(file_ + ": is empty; expected a header row with RTDE's names");
}

void LogTable::take_names(std::string_view columns) {
  const bool has_numbers =
      std::any_of(cells_.begin(), cells_.end(), [](std::string_view cell) { return number_in(cell).has_value(); });
  if (columns.empty()) {
    const bool all_numbers =
        std::all_of(cells_.begin(), cells_.end(), [](std::string_view cell) { return number_in(cell).has_value(); });
    if (all_numbers) {
      throw Error(
          fmt::format("{}: begins with a row of {} numbers, and has no header; expected a header row with RTDE's names, or "
                      "--robot-columns with a name or - for each column",
                      file_, cells_.size()));
    }
    names_.assign(cells_.begin(), cells_.end());
    return;
  }
  names_ = column_names(columns);
  if (names_.size() != cells_.size()) {
    throw Error(fmt::format("{}: row {} has {} values, but --robot-columns names {}; expected a name or - for each", file_,
                            number_, cells_.size(), names_.size()));
  }
  is_read_ = has_numbers;
}

std::optional<std::size_t> LogTable::find(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  if (std::find(found + 1, names_.end(), name) != names_.end())
    throw Error(fmt::format("{}: two columns have the name '{}'; expected one", file_, name));
  return static_cast<std::size_t>(found - names_.begin());
}

bool LogTable::next() {
  if (std::exchange(is_read_, false)) return true;
  if (!read_line()) return false;
  split();
  return true;
}

int LogTable::next_byte() {
  if (chunk_at_ == chunk_size_) {
    in_.read(chunk_.data(), static_cast<std::streamsize>(chunk_.size()));
    chunk_at_ = 0;
    chunk_size_ = static_cast<std::size_t>(in_.gcount());
    if (in_.bad()) throw Error(file_ + ": reading failed; expected a readable file");
    if (chunk_size_ == 0) return -1;
  }
  return static_cast<unsigned char>(chunk_[chunk_at_++]);
}

bool LogTable::read_line() {
  line_.clear();
  ++number_;
  for (int byte = next_byte();; byte = next_byte()) {
    if (byte < 0) {
      is_ended_ = false;
      return !line_.empty();
    }
    if (byte == '\n' || byte == '\r') {
      while (byte == '\r') byte = next_byte();
      if (byte >= 0 && byte != '\n') --chunk_at_;  // it was read just now, so it is still there
      is_ended_ = true;
      return true;
    }
    line_ += static_cast<char>(byte);
    if (line_.size() > longest_row)
      throw Error(fmt::format("{}: row {} has no end within {} bytes; expected text in rows", file_, number_, longest_row));
  }
}

void LogTable::split() {
  cells_.clear();
  const std::string_view line = trimmed(line_);
  if (line.empty()) return;
  for (std::size_t begin = 0;;) {
    // Aligned columns have several blanks between them.
    while (separator_ == ' ' && begin < line.size() && line[begin] == ' ') ++begin;
    std::size_t end = line.find(separator_, begin);
    const std::size_t first = line.find_first_not_of(" \t", begin);
    if (first != std::string_view::npos && line[first] == '"' && first < end) {
      std::size_t close = line.find('"', first + 1);
      while (close != std::string_view::npos && close + 1 < line.size() && line[close + 1] == '"')
        close = line.find('"', close + 2);
      if (close != std::string_view::npos) {
        cells_.push_back(line.substr(first + 1, close - first - 1));
        end = line.find(separator_, close + 1);
        if (end == std::string_view::npos) return;
        begin = end + 1;
        continue;
      }
    }
    cells_.push_back(trimmed(line.substr(begin, end == std::string_view::npos ? end : end - begin)));
    if (end == std::string_view::npos) return;
    begin = end + 1;
  }
}

double LogTable::number_at(std::size_t column) const {
  const std::optional<double> value = number_in(cells_[column]);
  if (!value || !std::isfinite(*value)) refuse(column, "a finite number");
  return *value;
}

std::int64_t LogTable::whole_number_at(std::size_t column) const {
  if (const std::optional<std::int64_t> value = whole_number_in(cells_[column])) return *value;
  const std::optional<double> value = number_in(cells_[column]);
  constexpr double limit = 9007199254740992.0;  // 2^53: beyond it a double skips whole numbers
  if (!value || !(std::abs(*value) <= limit) || *value != std::floor(*value)) refuse(column, "a whole number");
  return static_cast<std::int64_t>(*value);
}

std::uint64_t LogTable::bits_at(std::size_t column) const {
  const std::string_view cell = cells_[column];
  if (cell == "True" || cell == "False") return cell == "True" ? 1 : 0;
  std::uint64_t bits = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), bits);
  if (error == std::errc{} && end == cell.data() + cell.size()) return bits;
  const std::optional<double> value = number_in(cell);
  constexpr double limit = 9007199254740992.0;
  if (!value || !(*value >= 0.0 && *value <= limit) || *value != std::floor(*value))
    refuse(column, "a whole number of at least 0");
  return static_cast<std::uint64_t>(*value);
}

void LogTable::refuse_row() const {
  throw Error(
      fmt::format("{}: row {} has {} values; expected {}, as in its header", file_, number_, cells_.size(), names_.size()));
}

void LogTable::refuse(std::size_t column, std::string_view expected) const {
  throw Error(fmt::format("{}: row {}, column '{}' holds {}; expected {}", file_, number_, names_[column],
                          shown_text(cells_[column]), expected));
}

}  // namespace tactile::robot
