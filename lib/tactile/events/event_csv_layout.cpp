#include "tactile/events/event_csv_layout.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>

#include "tactile/core/csv.hpp"
#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::events {
namespace {

constexpr std::array<std::string_view, 4> unit_names{"s", "ms", "us", "ns"};
constexpr std::array<double, 4> stamps_per_unit{1e6, 1e3, 1.0, 1.0};
constexpr std::array<std::string_view, 4> column_names{"t", "x", "y", "p"};

/// The lower-case words of a column's name, without quotes, brackets and marks: "Time [s]" is time, s.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const bool is_upper = c >= 'A' && c <= 'Z', is_other = static_cast<unsigned char>(c) >= 0x80;
    if (is_upper || is_other || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
      words.back() += is_upper ? static_cast<char>(c - 'A' + 'a') : c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::optional<TimeUnit> unit_in(const std::string& word) {
  if (word == "s" || word == "sec" || word == "secs" || word == "seconds") return TimeUnit::s;
  if (word == "ms" || word == "milliseconds") return TimeUnit::ms;
  if (word == "us" || word == "usec" || word == "microseconds" || word == "\xC2\xB5s" || word == "\xCE\xBCs") return TimeUnit::us;
  if (word == "ns" || word == "nsec" || word == "nanoseconds") return TimeUnit::ns;
  return std::nullopt;
}

EventColumn column_named(std::string_view name, std::optional<TimeUnit>& unit) {
  const std::vector<std::string> words = words_of(name);
  if (words.empty() || words.size() > 2) return EventColumn::skipped;
  const auto is_one_of = [&](std::initializer_list<std::string_view> known) {
    return std::find(known.begin(), known.end(), words.front()) != known.end();
  };
  const std::optional<TimeUnit> named = words.size() == 2 ? unit_in(words.back()) : std::nullopt;
  if (is_one_of({"t", "ts", "time", "times", "timestamp", "timestamps"}) && (words.size() == 1 || named)) {
    unit = named;
    return EventColumn::t;
  }
  const bool is_plain = words.size() == 1 || words.back() == "px";
  if (is_plain && words.front() == "x") return EventColumn::x;
  if (is_plain && words.front() == "y") return EventColumn::y;
  return words.size() == 1 && is_one_of({"p", "pol", "polarity", "on"}) ? EventColumn::on : EventColumn::skipped;
}

std::vector<std::string_view> cells_of(std::string_view row, char separator) {
  std::vector<std::string_view> cells;
  split_cells(row, separator, cells);
  return cells;
}

/// The one of t, x, y and p that the columns do not have exactly once; empty if each is there once.
std::string_view misfit_of(const std::vector<EventColumn>& columns) {
  for (std::size_t i = 0; i < column_names.size(); ++i) {
    if (std::count(columns.begin(), columns.end(), static_cast<EventColumn>(i)) != 1) return column_names[i];
  }
  return {};
}

EventCsvLayout named_layout(std::string_view row) {
  EventCsvLayout layout{.separator = separator_of(row), .columns = {}, .names = {}, .has_header = true, .unit = {}};
  for (const std::string_view cell : cells_of(row, layout.separator)) {
    layout.columns.push_back(column_named(cell, layout.unit));
    layout.names.emplace_back(cell);
  }
  return layout;
}

EventCsvLayout given_layout(std::string_view row, const std::string& columns) {
  EventCsvLayout layout{.separator = separator_of(row), .columns = {}, .names = {}, .has_header = false, .unit = {}};
  for (const std::string_view name : cells_of(columns, ',')) {
    const EventColumn column = name == "-" ? EventColumn::skipped : column_named(name, layout.unit);
    if (column == EventColumn::skipped && name != "-") {
      throw Error(
          fmt::format("--columns {}: '{}' is no column of events; expected t, x, y and p, and - for one to skip", columns, name));
    }
    layout.columns.push_back(column);
    layout.names.emplace_back(name);
  }
  if (const std::string_view misfit = misfit_of(layout.columns); !misfit.empty())
    throw Error(
        fmt::format("--columns {}: does not have {} once; expected t, x, y and p, and - for one to skip", columns, misfit));
  const std::vector<std::string_view> cells = cells_of(row, layout.separator);
  if (cells.size() != layout.columns.size()) {
    throw Error(fmt::format("--columns {}: names {} columns, but the first row has {}; expected a name or - for each", columns,
                            layout.columns.size(), cells.size()));
  }
  layout.has_header = std::none_of(cells.begin(), cells.end(), [](std::string_view cell) { return number_in(cell).has_value(); });
  return layout;
}

}  // namespace

std::string_view name_of(TimeUnit unit) { return unit_names.at(static_cast<std::size_t>(unit)); }

TimeUnit time_unit_named(std::string_view name) { return enumerator_named<TimeUnit>(name, unit_names, "time unit"); }

EventCsvLayout layout_of(std::string_view row, const EventCsvOptions& options) {
  EventCsvLayout layout = options.columns.empty() ? named_layout(row) : given_layout(row, options.columns);
  if (const std::string_view misfit = misfit_of(layout.columns); !misfit.empty()) {
    std::string shown;
    for (const char c : row.substr(0, 40)) shown += c >= ' ' && c < 127 ? c : '?';
    throw Error(
        fmt::format("'{}{}' does not name {} once; expected a header row such as 't_us,x,y,on', or --columns with t, x, y "
                    "and p in the file's order",
                    shown, row.size() > 40 ? "..." : "", misfit == "t" ? "a column of times" : misfit));
  }
  if (options.time_unit) layout.unit = options.time_unit;
  return layout;
}

std::optional<EventCsvLayout> layout_in_comment(std::string_view row) {
  row.remove_prefix(std::min(row.find_first_not_of("#% \t"), row.size()));
  EventCsvLayout layout = named_layout(row);
  return misfit_of(layout.columns).empty() ? std::optional(std::move(layout)) : std::nullopt;
}

TimeUnit unit_of_times(std::string_view rows, const EventCsvLayout& layout) {
  const auto column =
      static_cast<std::size_t>(std::find(layout.columns.begin(), layout.columns.end(), EventColumn::t) - layout.columns.begin());
  constexpr double beyond_microseconds = 1e17;  // the year 5138, or nanoseconds since 1973
  std::size_t with_point = 0;
  for (CsvRows row(rows); row.next();) {
    const std::vector<std::string_view> cells = cells_of(row.row(), layout.separator);
    if (cells.size() <= column) continue;
    const std::optional<double> time = number_in(cells[column]);
    if (!time) continue;
    if (*time != std::floor(*time)) return TimeUnit::s;
    if (std::abs(*time) >= beyond_microseconds)
      throw Error(fmt::format("the time {} is no time in microseconds; expected --time-unit ns, or another unit", cells[column]));
    if (cells[column].find_first_of(".eE") != std::string_view::npos) ++with_point;
  }
  if (with_point > 0)
    throw Error(
        "the first times have a decimal point, but no fraction, so their unit is unknown; expected --time-unit s, ms, us or ns");
  return TimeUnit::us;
}

std::size_t read_stamp(std::string_view text, TimeUnit unit, std::int64_t& stamp) {
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const auto [whole_end, error] = std::from_chars(begin, end, stamp);
  const bool is_whole =
      error == std::errc{} && (whole_end == end || (*whole_end != '.' && *whole_end != 'e' && *whole_end != 'E'));
  // A double has too few digits for nanoseconds since 1970.
  if (is_whole && (unit == TimeUnit::us || unit == TimeUnit::ns)) return static_cast<std::size_t>(whole_end - begin);
  double value = 0;
  const auto [number_end, problem] = std::from_chars(begin, end, value);
  const double rounded = std::floor(value * stamps_per_unit[static_cast<std::size_t>(unit)] + 0.5);
  if (problem != std::errc{} || !(std::abs(rounded) < 9e18)) return 0;
  stamp = static_cast<std::int64_t>(rounded);
  return static_cast<std::size_t>(number_end - begin);
}

std::int64_t us_of_stamp(std::int64_t stamp, TimeUnit unit) {
  if (unit != TimeUnit::ns) return stamp;
  const std::int64_t rest = stamp % 1000;
  return stamp / 1000 + (rest >= 500 ? 1 : 0) - (rest < -500 ? 1 : 0);
}

}  // namespace tactile::events
