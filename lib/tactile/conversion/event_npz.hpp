#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "tactile/events/event.hpp"

namespace tactile {

/// Writes events as NumPy's `np.load(file)["events"]` has them: one structured array with the fields t_us (int64), x, y (uint16)
/// and on (uint8), little-endian, 13 bytes each without gaps; and `sensor_size`, int32 [width, height]. The entries of the ZIP
/// archive are stored as they are, in its 64-bit form, without times: the same events give the same bytes, of any number.
///
/// Written from front to back with a fixed buffer; the head of the array, which counts the events, is filled in at the end. That
/// is why no library writes the archive: they ask for an entry's contents only once they are all there.
///
/// Source: NumPy's NEP 1 (format 1.0) and PKWARE's APPNOTE 6.3 (4.3.7, 4.3.9 to 4.3.16, 4.5.3).
class EventNpzWriter {
 public:
  /// @throws Error if the file cannot be made
  EventNpzWriter(const std::filesystem::path& file, SensorSize size);
  ~EventNpzWriter();
  EventNpzWriter(EventNpzWriter&&) noexcept;
  EventNpzWriter& operator=(EventNpzWriter&&) noexcept;

  void write(std::span<const Event> events);  ///< places must be >= 0. @throws Error if the disk does not take them
  std::uint64_t steps_back() const;           ///< in time, so far
  void close();                               ///< ends the file; nothing may be written after. @throws Error likewise

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
