#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "tactile/events/event.hpp"

namespace tactile {

/// Events as text: this line, then one event a line, four whole numbers without spaces: camera time [us], pixel from the left,
/// pixel from the top, 1 brighter or 0 darker. Lines end in LF (CR LF is read too). A recording whose time steps back is written
/// as it is; reading refuses it.
inline constexpr std::string_view event_csv_header = "t_us,x,y,on";

class EventCsvWriter {
 public:
  explicit EventCsvWriter(const std::filesystem::path& file);  ///< writes the header. @throws Error if the file cannot be made
  ~EventCsvWriter();
  EventCsvWriter(EventCsvWriter&&) noexcept;
  EventCsvWriter& operator=(EventCsvWriter&&) noexcept;

  void write(std::span<const Event> events);  ///< @throws Error if the disk does not take them
  std::uint64_t steps_back() const;           ///< in time, so far
  void close();                               ///< writes what waits; nothing may be written after. @throws Error likewise

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads such a file in chunks; memory follows the chunk.
class EventCsvReader {
 public:
  /// `size`: the sensor that events must lie in; without it, coordinates are 0 to 32767.
  /// @throws Error  if the file cannot be read or does not begin with the header
  explicit EventCsvReader(const std::filesystem::path& file, std::optional<SensorSize> size = std::nullopt);
  ~EventCsvReader();
  EventCsvReader(EventCsvReader&&) noexcept;
  EventCsvReader& operator=(EventCsvReader&&) noexcept;

  /// The next events, at least one until the file ends; valid until the next call.
  /// @throws Error  that names the line, what is wrong and what would be right
  std::span<const Event> next();

  std::uint64_t bytes_read() const;
  std::uint64_t file_size() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
