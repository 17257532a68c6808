#include "tactile/events/event_csv.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"

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

std::string shown(std::string_view text) {
  std::string plain;
  for (const char c : text.substr(0, 40)) plain += c >= ' ' && c < 127 ? c : '?';
  return "'" + plain + (text.size() > 40 ? "...'" : "'");
}

/// Reads a whole number and the comma after it; false if there is none.
template <class T>
bool take(const char*& at, const char* end, T& value) {
  const auto [rest, error] = std::from_chars(at, end, value);
  if (error != std::errc{} || rest == end || *rest != ',') return false;
  at = rest + 1;
  return true;
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
  State(const std::filesystem::path& csv, SensorSize size)
      : path(csv), file(open_file(csv, "rbe", "a readable file")), sensor(size) {}

  std::filesystem::path path;
  File file;
  SensorSize sensor;
  std::uint64_t size_bytes = 0;
  std::vector<char> buffer = std::vector<char>(chunk_bytes + longest_line);
  std::size_t waiting = 0;  ///< bytes at the buffer's begin that are not parsed yet
  bool at_end = false;
  std::uint64_t bytes = 0;
  std::uint64_t line = 0;  ///< the last one parsed, from 1
  CameraTime latest = CameraTime::min();
  std::vector<Event> events;  ///< parsed ones; the constructor parses the first chunk for the header
  bool handed_out = false;

  [[noreturn]] void refuse(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", path.string(), line, what)); }

  void read_header(std::string_view text) {
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    if (text != event_csv_header) refuse(fmt::format("{} is not the header; expected '{}'", shown(text), event_csv_header));
  }

  void read_event(std::string_view text) {
    const char* at = text.data();
    const char* const end = at + text.size();
    std::int64_t t = 0;
    int x = 0, y = 0;
    if (!take(at, end, t) || !take(at, end, x) || !take(at, end, y) || end - at != 1 || (*at != '0' && *at != '1') || x < 0 ||
        y < 0 || x >= sensor.width || y >= sensor.height) {
      refuse_event(text);
    }
    const CameraTime time = camera_time(t);
    if (time < latest) refuse(fmt::format("time goes back from {} to {}; expected times that never go back", us_of(latest), t));
    latest = time;
    Event event{.t = time, .x = static_cast<std::int16_t>(x), .y = static_cast<std::int16_t>(y)};
    event.on = *at == '1' ? 1 : 0;
    events.push_back(event);
  }

  /// Finds the error for the message; slow.
  [[noreturn]] void refuse_event(std::string_view text) const {
    const std::vector<std::string_view> fields = split_cells(text);
    if (text.empty()) refuse("the line is empty; expected an event, 't_us,x,y,on'");
    if (fields.size() != 4)
      refuse(fmt::format("{} has {} field{}; expected the four of '{}'", shown(text), fields.size(),
                         fields.size() == 1 ? "" : "s", event_csv_header));
    const auto check = [&](std::string_view name, std::string_view field, std::int64_t least, std::int64_t most) {
      std::int64_t value = 0;
      const auto [rest, error] = std::from_chars(field.data(), field.data() + field.size(), value);
      if (error != std::errc{} || rest != field.data() + field.size() || value < least || value > most) {
        refuse(fmt::format("{} is {}; expected a whole number from {} to {}", name, shown(field), least, most));
      }
    };
    check("t_us", fields[0], std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max());
    check("x", fields[1], 0, sensor.width - 1);
    check("y", fields[2], 0, sensor.height - 1);
    refuse(fmt::format("on is {}; expected 0 or 1", shown(fields[3])));
  }

  void read_line(std::string_view text) {
    ++line;
    if (text.ends_with('\r')) text.remove_suffix(1);
    line == 1 ? read_header(text) : read_event(text);
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
      read_line({at, static_cast<std::size_t>(newline - at)});
      at = newline + 1;
    }
    waiting = static_cast<std::size_t>(end - at);
    if (waiting > longest_line) {
      ++line;
      refuse(fmt::format("the line is longer than {} bytes; expected lines of '{}'", longest_line, event_csv_header));
    }
    if (at_end && waiting > 0) {
      read_line({at, waiting});
      waiting = 0;
    }
    std::memmove(buffer.data(), at, waiting);
  }
};

EventCsvReader::EventCsvReader(const std::filesystem::path& file, std::optional<SensorSize> size)
    : state_(std::make_unique<State>(file, size.value_or(widest_sensor))) {
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(file, unknown);
  state_->size_bytes = unknown ? 0 : bytes;
  while (state_->line == 0 && !state_->at_end) state_->read_chunk();
  if (state_->line == 0)
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

std::uint64_t EventCsvReader::bytes_read() const { return state_->bytes; }
std::uint64_t EventCsvReader::file_size() const { return state_->size_bytes; }

}  // namespace tactile::events
