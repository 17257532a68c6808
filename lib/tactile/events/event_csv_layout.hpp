#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactile::events {

enum class TimeUnit : std::uint8_t { s, ms, us, ns };

std::string_view name_of(TimeUnit unit);          ///< "s", "ms", "us", "ns"
TimeUnit time_unit_named(std::string_view name);  ///< @throws Error if it is none of the four

/// What a file of events does not say about itself.
struct EventCsvOptions {
  std::string columns{};                ///< "t,x,y,p": the columns in their order, `-` for one to skip; empty: by the header row
  std::optional<TimeUnit> time_unit{};  ///< of the times; nothing: by the header row, else by the numbers
};

/// What a column of a text file of events holds.
enum class EventColumn : std::uint8_t { t, x, y, on, skipped };

/// How a text file of events is laid out.
struct EventCsvLayout {
  char separator = ',';  ///< comma, semicolon, tab or blank; several blanks count as one
  std::vector<EventColumn> columns;
  std::vector<std::string> names;  ///< of the columns, for errors
  bool has_header = false;         ///< the row that gave the layout names the columns; else it is an event
  std::optional<TimeUnit> unit;    ///< of the times, if it is known
};

/// The layout that the first row of a file shows. A name may be in upper or lower case, in quotes, and with its unit: `t`, `ts`,
/// `time`, `timestamp`, `timestamp_us`, `Time [s]`; `x`; `y`; `p`, `pol`, `polarity`, `on`. Other columns are skipped.
/// @param row  the first row that is no comment, without its end
/// @throws Error  without the file's name, if it does not name each of t, x, y and p once, or `options.columns` does not fit
EventCsvLayout layout_of(std::string_view row, const EventCsvOptions& options);

/// The same for a comment, which may be a header row after its mark: "# t,x,y,p"; nothing if it is none.
std::optional<EventCsvLayout> layout_in_comment(std::string_view row);

/// The unit of times without a name of it: whole numbers are microseconds, numbers with a fraction are seconds.
/// @param rows  the first rows of the file
/// @throws Error  without the file's name, if the numbers are whole but have a decimal point, or are beyond any clock of
///                microseconds
TimeUnit unit_of_times(std::string_view rows, const EventCsvLayout& layout);

/// Reads a number from the start of `text` as whole nanoseconds if these are its unit, else as whole microseconds, rounded half
/// up.
/// @return  the part that was read; 0 if there is no number, or it is out of range
std::size_t read_stamp(std::string_view text, TimeUnit unit, std::int64_t& stamp);

std::int64_t us_of_stamp(std::int64_t stamp, TimeUnit unit);  ///< whole microseconds, rounded half up

}  // namespace tactile::events
