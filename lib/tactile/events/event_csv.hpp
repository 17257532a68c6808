#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "tactile/events/event.hpp"
#include "tactile/events/event_csv_layout.hpp"

namespace tactile::events {

/// Events as text: this header line, then one event per line, four whole numbers without spaces: camera time [us], pixel from the
/// left, pixel from the top, 1 brighter or 0 darker. Lines end in LF. Steps back in time are written, but refused when reading.
inline constexpr std::string_view event_csv_header = "t_us,x,y,on";

class EventCsvWriter {
 public:
  explicit EventCsvWriter(const std::filesystem::path& file);  ///< writes the header. @throws Error if the file cannot be made
  ~EventCsvWriter();
  EventCsvWriter(EventCsvWriter&&) noexcept;
  EventCsvWriter& operator=(EventCsvWriter&&) noexcept;

  void write(std::span<const Event> events);  ///< @throws Error if writing fails
  std::uint64_t steps_back() const;           ///< in time, so far
  void close();                               ///< writes the rest; no further writes. @throws Error if writing fails

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The overflows of the counter that gave a file's times: its range was added after each.
struct TimeOverflows {
  std::uint64_t count = 0;
  std::uint64_t line = 0;  ///< of the first event after the first overflow
  int bits = 0;
  TimeUnit unit = TimeUnit::us;  ///< that it counts
  CameraTime before{}, after{};  ///< the times on either side of the first, as in the file
};

/// Reads such a file, and those of other programs, in chunks; memory follows the chunk. The columns may have any order
/// (`layout_of`); times may be in seconds; polarities may be 0 and 1, -1 and 1, or False and True. Comments (`#`, `%`) before the
/// first row are skipped. Lines end in LF or CR LF.
///
/// Times that fall from `b` to `a` have passed the overflow of a counter of 24, 31 or 32 bits, which counts R microseconds, if
/// b < R and the gap between the two events, R - b + a, is from 0 to R / 32. R is added from there on. Counters of 31 and 32 bits
/// of nanoseconds are known too, where nanoseconds are the unit.
class EventCsvReader {
 public:
  /// @param size  of the sensor; without it, coordinates are limited to 0 to 32767
  /// @throws Error  if the file cannot be read, or its columns or the unit of its times are unknown
  explicit EventCsvReader(const std::filesystem::path& file, std::optional<SensorSize> size = std::nullopt,
                          const EventCsvOptions& options = {});
  ~EventCsvReader();
  EventCsvReader(EventCsvReader&&) noexcept;
  EventCsvReader& operator=(EventCsvReader&&) noexcept;

  /// The next events, at least one until the file ends; valid until the next call.
  /// @throws Error  with the line, what is wrong and what is expected
  std::span<const Event> next();

  TimeUnit time_unit() const;
  bool time_unit_guessed() const;          ///< from the numbers alone, and it is not microseconds
  const TimeOverflows& overflows() const;  ///< in what has been read
  std::uint64_t bytes_read() const;
  std::uint64_t file_size() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::events
