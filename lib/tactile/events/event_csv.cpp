#include "tactile/events/event_csv.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/text_lines.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 20;
constexpr std::size_t longest_line = 4096;   // much longer than an event; a file without line ends is refused early
constexpr std::size_t longest_written = 48;  // 20 digits of time, two coordinates, polarity, separators
constexpr SensorSize widest_sensor{std::numeric_limits<std::int16_t>::max() + 1, std::numeric_limits<std::int16_t>::max() + 1};
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

File open_file(const std::filesystem::path& file, const char* mode, const char* expected) {
  File opened(std::filesystem::is_directory(file) ? nullptr : std::fopen(file.c_str(), mode));
  if (!opened)
    throw Error(fmt::format("{}: cannot be opened ({}); expected {}", file.string(),
                            std::filesystem::is_directory(file) ? "a folder" : std::strerror(errno), expected));
  std::setvbuf(opened.get(), nullptr, _IONBF, 0);  // the chunks are the buffer
  return opened;
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// A counter that gives times: after its greatest number it starts again at its least.
struct TimeCounter {
  int bits = 0;
  TimeUnit unit = TimeUnit::us;  ///< that it counts
  std::int64_t range = 0;        ///< in stamps of the file

  /// Between the events on either side of an overflow. A clock that starts again from 0 looks the same only if it stops in the
  /// last 1/32 of the range: 16 s are not the end of 24 bits, nor are 4 s of 32 bits of nanoseconds. A gap in the events of more
  /// than 0.5 s, 1/32 of 24 bits, is rare.
  std::int64_t longest_gap() const { return range / 32; }
  std::string range_text() const { return fmt::format("{} {}", std::int64_t{1} << bits, name_of(unit)); }
};

/// The counter that may have passed its greatest number where stamps fall, whatever the gap; nothing if there is none.
std::optional<TimeCounter> counter_that_falls(std::int64_t before, std::int64_t after, TimeUnit stamp_unit) {
  const std::int64_t stamps_per_us = stamp_unit == TimeUnit::ns ? 1000 : 1;
  for (const auto& [bits, unit] : std::initializer_list<std::pair<int, TimeUnit>>{
           {31, TimeUnit::ns}, {32, TimeUnit::ns}, {24, TimeUnit::us}, {31, TimeUnit::us}, {32, TimeUnit::us}}) {
    if (unit == TimeUnit::ns && stamp_unit != TimeUnit::ns) continue;
    const std::int64_t range = (std::int64_t{1} << bits) * (unit == TimeUnit::us ? stamps_per_us : 1);
    if (before >= range || after < -range) continue;
    if (before - after > range / 2 && before - after <= range) return TimeCounter{bits, unit, range};
  }
  return std::nullopt;
}

/// Moves to the next cell, past blanks around the separator; false if there is none.
bool pass_separator(const char*& at, const char* end, char separator) {
  while (at < end && is_blank(*at) && *at != separator) ++at;
  if (at == end || *at != separator) return false;
  for (++at; at < end && (*at == ' ' || (*at == '\t' && separator == ' ')); ++at) continue;
  return true;
}

/// Reads a coordinate; false if there is none, or it is not below `limit`.
bool take_coordinate(const char*& at, const char* end, int limit, std::int16_t& value) {
  int number = 0;
  const auto [rest, error] = std::from_chars(at, end, number);
  if (error != std::errc{} || number < 0 || number >= limit) return false;
  value = static_cast<std::int16_t>(number);
  at = rest;
  return true;
}

/// Reads a polarity: 1, 0, -1, True or False; nothing if it is none.
std::optional<int> take_polarity(const char*& at, const char* end) {
  const std::string_view text(at, static_cast<std::size_t>(end - at));
  constexpr std::array<std::pair<std::string_view, int>, 7> known{
      {{"1", 1}, {"0", 0}, {"-1", -1}, {"True", 1}, {"False", 0}, {"true", 1}, {"false", 0}}};
  const auto* const found = std::find_if(known.begin(), known.end(), [&](const auto& k) { return text.starts_with(k.first); });
  if (found == known.end()) return std::nullopt;
  at += found->first.size();
  return found->second;
}

}  // namespace

struct EventCsvWriter::State {
  explicit State(const std::filesystem::path& csv) : path(csv), file(open_file(csv, "wbe", "a writable place")) {}

  std::filesystem::path path;
  File file;
  std::vector<char> buffer = std::vector<char>(chunk_bytes);
  std::size_t used = 0;
  CameraTime previous = CameraTime::min();
  std::uint64_t steps_back = 0;

  void put() {
    if (std::fwrite(buffer.data(), 1, used, file.get()) != used) {
      throw Error(fmt::format("{}: cannot be written ({}); expected a place with room", path.string(), std::strerror(errno)));
    }
    used = 0;
  }
};

EventCsvWriter::EventCsvWriter(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {
  std::memcpy(state_->buffer.data(), event_csv_header.data(), event_csv_header.size());
  state_->used = event_csv_header.size();
  state_->buffer[state_->used++] = '\n';
}

EventCsvWriter::~EventCsvWriter() = default;
EventCsvWriter::EventCsvWriter(EventCsvWriter&&) noexcept = default;
EventCsvWriter& EventCsvWriter::operator=(EventCsvWriter&&) noexcept = default;

void EventCsvWriter::write(std::span<const Event> events) {
  State& state = *state_;
  for (const Event& event : events) {
    if (state.buffer.size() - state.used < longest_written) state.put();
    if (event.t < state.previous) ++state.steps_back;
    state.previous = event.t;
    char* at = state.buffer.data() + state.used;
    char* const end = state.buffer.data() + state.buffer.size();
    at = std::to_chars(at, end, us_of(event.t)).ptr;
    *at++ = ',';
    at = std::to_chars(at, end, event.x).ptr;
    *at++ = ',';
    at = std::to_chars(at, end, event.y).ptr;
    *at++ = ',';
    *at++ = event.on != 0 ? '1' : '0';
    *at++ = '\n';
    state.used = static_cast<std::size_t>(at - state.buffer.data());
  }
}

std::uint64_t EventCsvWriter::steps_back() const { return state_->steps_back; }

void EventCsvWriter::close() {
  state_->put();
  if (std::fclose(state_->file.release()) != 0) {
    throw Error(
        fmt::format("{}: cannot be written ({}); expected a place with room", state_->path.string(), std::strerror(errno)));
  }
}

struct EventCsvReader::State {
  State(const std::filesystem::path& csv, SensorSize size, const EventCsvOptions& csv_options)
      : path(csv), file(open_file(csv, "rbe", "a readable file")), sensor(size), options(csv_options) {}

  std::filesystem::path path;
  File file;
  SensorSize sensor;
  EventCsvOptions options;
  std::optional<EventCsvLayout> layout;          ///< once the first row was read
  std::optional<EventCsvLayout> comment_layout;  ///< of a comment that names the columns
  TimeUnit unit = TimeUnit::us;
  bool unit_guessed = false;
  int lowest_polarity = 1;  ///< 0 or -1 once one was read
  std::uint64_t size_bytes = 0;
  std::vector<char> buffer = std::vector<char>(chunk_bytes + longest_line);
  std::size_t waiting = 0;  ///< bytes at the buffer's start that are not parsed yet
  bool at_end = false;
  std::uint64_t bytes = 0;
  std::uint64_t line = 0;                                          ///< the last one parsed, from 1
  std::uint64_t rows_above = 0;                                    ///< comments and header
  std::int64_t latest = std::numeric_limits<std::int64_t>::min();  ///< stamp, as in the file
  std::int64_t added = 0;                                          ///< to the stamps, since the counter overflowed
  std::optional<TimeCounter> counter;                              ///< once it overflowed
  TimeOverflows overflows;
  std::vector<Event> events;  ///< parsed ones; the constructor parses the first chunk for the header
  bool handed_out = false;

  [[noreturn]] void refuse(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", path.string(), line, what)); }

  /// Reads the first row that is no comment. @param rest  the chunk from this row on
  void read_first_row(std::string_view text, std::string_view rest) {
    if (text.starts_with('#') || text.starts_with('%')) {
      if (options.columns.empty() && !comment_layout) comment_layout = layout_in_comment(text);
      return;
    }
    try {
      layout = comment_layout ? comment_layout : layout_of(text, options);
      if (comment_layout) layout->has_header = false;
      if (options.time_unit) layout->unit = options.time_unit;
      unit = layout->unit ? *layout->unit : unit_of_times(rest, *layout);
      unit_guessed = !layout->unit && unit != TimeUnit::us;
    } catch (const Error& e) {
      refuse(e.what());
    }
    rows_above = layout->has_header ? line : line - 1;
    if (!layout->has_header) read_event(text);
  }

  void read_event(std::string_view text) {
    const char* at = text.data();
    const char* const end = at + text.size();
    const std::vector<EventColumn>& columns = layout->columns;
    Cells cells;
    while (at < end && is_blank(*at)) ++at;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0 && !pass_separator(at, end, layout->separator)) refuse_event(text);
      if (!read_cell(columns[i], at, end, cells)) refuse_event(text);
    }
    while (at < end && is_blank(*at)) ++at;
    if (at != end) refuse_event(text);
    Event& event = cells.event;
    if (!follows(cells.stamp)) undo_overflow(cells.stamp);
    latest = cells.stamp;
    event.t = camera_time(us_with(added, cells.stamp));
    event.on = cells.polarity > 0 ? 1 : 0;
    if (cells.polarity <= 0 && cells.polarity != lowest_polarity) note_polarity(cells.polarity);
    events.push_back(event);
  }

  /// The values of a row while it is read.
  struct Cells {
    Event event;
    std::int64_t stamp = 0;
    int polarity = 0;
  };

  bool read_cell(EventColumn column, const char*& at, const char* end, Cells& cells) const {
    switch (column) {
      case EventColumn::t: {
        const std::size_t length = read_stamp({at, static_cast<std::size_t>(end - at)}, unit, cells.stamp);
        at += length;
        return length > 0;
      }
      case EventColumn::x:
        return take_coordinate(at, end, sensor.width, cells.event.x);
      case EventColumn::y:
        return take_coordinate(at, end, sensor.height, cells.event.y);
      case EventColumn::on: {
        const std::optional<int> polarity = take_polarity(at, end);
        cells.polarity = polarity.value_or(0);
        return polarity.has_value();
      }
      case EventColumn::skipped:
        at = std::find(at, end, layout->separator);
        return true;
    }
    return false;
  }

  std::int64_t us_with(std::int64_t add, std::int64_t stamp) const { return us_of_stamp(saturating_add(stamp, add), unit); }

  /// Whether the stamp is not before the latest one. After an overflow a step forward of nearly the range is none: the event is
  /// from before the overflow.
  bool follows(std::int64_t stamp) const {
    return stamp >= latest && (!counter || (stamp < counter->range && stamp - latest < counter->range - counter->longest_gap()));
  }

  /// Adds the counter's range from this stamp on.
  /// @throws Error  if the step to the stamp is no counter's overflow
  void undo_overflow(std::int64_t stamp) {
    if (counter && stamp >= latest && stamp >= counter->range) refuse_counter(stamp, *counter);
    if (counter && stamp >= latest) refuse_order(stamp, added - counter->range);
    const std::optional<TimeCounter> fallen = counter_that_falls(latest, stamp, unit);
    if (!fallen || (counter && counter->range != fallen->range)) refuse_order(stamp, added);
    const std::int64_t gap = fallen->range - (latest - stamp);
    if (gap > fallen->longest_gap() && counter) refuse_order(stamp, added);
    if (gap > fallen->longest_gap()) refuse_fall(stamp, *fallen, gap);
    if (overflows.count++ == 0) {
      overflows = {.count = 1,
                   .line = line,
                   .bits = fallen->bits,
                   .unit = fallen->unit,
                   .before = camera_time(us_with(0, latest)),
                   .after = camera_time(us_with(0, stamp))};
    }
    counter = fallen;
    added = saturating_add(added, fallen->range);
  }

  /// A clock that counts on past the range of its counter shows that the counter did not overflow.
  [[noreturn]] void refuse_counter(std::int64_t stamp, const TimeCounter& beyond) const {
    refuse(fmt::format(
        "the time {} us is beyond the range of a counter of {} bits, whose overflow line {} shows; expected less than {}; if the "
        "clock started again in line {}, cut the file before that line",
        us_with(0, stamp), beyond.bits, overflows.line, beyond.range_text(), overflows.line));
  }

  std::string step_back(std::int64_t stamp, std::int64_t add) const {
    return fmt::format("time goes back from {} to {} us; expected times that never go back; ", us_with(added, latest),
                       us_with(add, stamp));
  }

  /// Rows out of order do not fall so far, and sorting would put the second half of the file first.
  [[noreturn]] void refuse_fall(std::int64_t stamp, const TimeCounter& fallen, std::int64_t gap) const {
    refuse(fmt::format(
        "{}if the clock started again here, cut the file before this line; if a counter of {} bits overflowed here, in a gap of "
        "{} us, add {} to the times from this line on",
        step_back(stamp, added), fallen.bits, us_of_stamp(gap, unit), fallen.range_text()));
  }

  /// Names a command that sorts the file, whatever its size; after an overflow, what to do first.
  /// @param add  to the stamp, for its time
  [[noreturn]] void refuse_order(std::int64_t stamp, std::int64_t add) const {
    if (counter) {
      refuse(
          fmt::format("{}the counter of {} bits overflowed in line {}, and sorting would mix the times before and after it: "
                      "add {} to the times after each overflow, then sort the file",
                      step_back(stamp, add), counter->bits, overflows.line, counter->range_text()));
    }
    const auto t = std::find(layout->columns.begin(), layout->columns.end(), EventColumn::t) - layout->columns.begin() + 1;
    const std::string separator = layout->separator == ' '    ? ""
                                  : layout->separator == '\t' ? "-t \"$(printf '\\t')\" "
                                                              : fmt::format("-t '{}' ", layout->separator);
    const std::string sort = fmt::format("LC_ALL=C sort -s {}-k {},{}g", separator, t, t), name = shell_word(path.string());
    const std::string command =
        rows_above == 0 ? fmt::format("{} {}", sort, name)
                        : fmt::format("(head -n {} {}; tail -n +{} {} | {})", rows_above, name, rows_above + 1, name, sort);
    refuse(
        fmt::format("{}if the clock started again here, cut the file before this line; if the rows are out of order, to sort the "
                    "file: {} > sorted.csv",
                    step_back(stamp, add), command));
  }

  void note_polarity(int polarity) {
    if (lowest_polarity <= 0) {
      refuse(fmt::format("the polarity is {}, and {} in a row above; expected 0 and 1, or -1 and 1", polarity, lowest_polarity));
    }
    lowest_polarity = polarity;
  }

  /// Finds the error for the message; slow.
  [[noreturn]] void refuse_event(std::string_view text) const {
    if (text.empty()) refuse(fmt::format("the line is empty; expected an event, {}", columns_text()));
    const std::size_t count = layout->columns.size();
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at < end && is_blank(*at)) ++at;
    for (std::size_t i = 0; i < count; ++i) {
      const char* const cell_end =
          layout->separator == ' ' ? std::find_if(at, end, is_blank) : std::find(at, end, layout->separator);
      const char* rest = at;
      Cells cells;
      const bool is_read = read_cell(layout->columns[i], rest, cell_end, cells);
      while (rest < cell_end && is_blank(*rest)) ++rest;
      if (!is_read || rest != cell_end) refuse_cell(i, {at, static_cast<std::size_t>(cell_end - at)});
      at = cell_end;
      if (i + 1 < count && !pass_separator(at, end, layout->separator)) break;
    }
    refuse(fmt::format("{} does not have {} cells; expected {}", shown_text(text), count, columns_text()));
  }

  [[noreturn]] void refuse_cell(std::size_t i, std::string_view cell) const {
    const auto whole_up_to = [](int most) { return fmt::format("a whole number from 0 to {}", most); };
    std::string expected = "0 and 1, or -1 and 1";
    if (layout->columns[i] == EventColumn::t) expected = fmt::format("a time in {}", name_of(unit));
    if (layout->columns[i] == EventColumn::x) expected = whole_up_to(sensor.width - 1);
    if (layout->columns[i] == EventColumn::y) expected = whole_up_to(sensor.height - 1);
    refuse(fmt::format("{} is {}; expected {}", layout->names[i], shown_text(cell), expected));
  }

  /// "the columns 't_us,x,y,on'".
  std::string columns_text() const {
    std::string text;
    for (const std::string& name : layout->names) text += (text.empty() ? "" : ",") + name;
    return "the columns " + shown_text(text);
  }

  /// @param rest  the chunk from this line on
  void read_line(std::string_view text, std::string_view rest) {
    if (++line == 1 && text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    if (text.ends_with('\r')) text.remove_suffix(1);
    layout ? read_event(text) : read_first_row(text, rest);
  }

  /// Parses the whole lines of the next chunk, and moves the rest to the front.
  void read_chunk() {
    const std::size_t got = std::fread(buffer.data() + waiting, 1, chunk_bytes, file.get());
    if (got < chunk_bytes && std::ferror(file.get()) != 0) {
      throw Error(fmt::format("{}: reading failed ({}); expected a readable file", path.string(), std::strerror(errno)));
    }
    at_end = got == 0;
    bytes += got;
    const char* at = buffer.data();
    const char* const end = at + waiting + got;
    while (at < end) {
      const auto* newline = static_cast<const char*>(std::memchr(at, '\n', static_cast<std::size_t>(end - at)));
      if (newline == nullptr) break;
      read_line({at, static_cast<std::size_t>(newline - at)}, {at, static_cast<std::size_t>(end - at)});
      at = newline + 1;
    }
    waiting = static_cast<std::size_t>(end - at);
    if (waiting > longest_line) {
      ++line;
      refuse(fmt::format("the line is longer than {} bytes; expected one event a line", longest_line));
    }
    if (at_end && waiting > 0) {
      read_line({at, waiting}, {at, waiting});
      waiting = 0;
    }
    std::memmove(buffer.data(), at, waiting);
  }
};

EventCsvReader::EventCsvReader(const std::filesystem::path& file, std::optional<SensorSize> size, const EventCsvOptions& options)
    : state_(std::make_unique<State>(file, size.value_or(widest_sensor), options)) {
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(file, unknown);
  state_->size_bytes = unknown ? 0 : bytes;
  while (!state_->layout && !state_->at_end) state_->read_chunk();
  if (!state_->layout && !state_->comment_layout)
    throw Error(fmt::format("{}: the file is empty; expected '{}' and one event a line", file.string(), event_csv_header));
}

EventCsvReader::~EventCsvReader() = default;
EventCsvReader::EventCsvReader(EventCsvReader&&) noexcept = default;
EventCsvReader& EventCsvReader::operator=(EventCsvReader&&) noexcept = default;

std::span<const Event> EventCsvReader::next() {
  State& state = *state_;
  if (state.handed_out) state.events.clear();
  state.handed_out = true;
  while (state.events.empty() && !state.at_end) state.read_chunk();
  return state.events;
}

TimeUnit EventCsvReader::time_unit() const { return state_->unit; }
bool EventCsvReader::time_unit_guessed() const { return state_->unit_guessed; }
const TimeOverflows& EventCsvReader::overflows() const { return state_->overflows; }
std::uint64_t EventCsvReader::bytes_read() const { return state_->bytes; }
std::uint64_t EventCsvReader::file_size() const { return state_->size_bytes; }

}  // namespace tactile::events
