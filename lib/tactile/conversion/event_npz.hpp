#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "tactile/events/event.hpp"

namespace tactile::conversion {

/// Writes events for NumPy. `np.load(file)["events"]` is a structured array with the fields t_us (int64), x, y (uint16) and
/// on (uint8), little-endian, 13 bytes each without gaps. `sensor_size` is int32 [width, height]. The entries of the ZIP archive
/// are stored uncompressed, in the 64-bit form, without times: the same events always give the same bytes.
///
/// The file is written from front to back with a fixed buffer. The head of the array has the number of events and is written
/// last. ZIP libraries do not allow that: they need an entry's complete contents at once.
///
/// Source: NumPy's NEP 1 (format 1.0) and PKWARE's APPNOTE 6.3 (4.3.7, 4.3.9 to 4.3.16, 4.5.3).
class EventNpzWriter {
 public:
  /// @throws Error if the file cannot be made
  EventNpzWriter(const std::filesystem::path& file, events::SensorSize size);
  ~EventNpzWriter();
  EventNpzWriter(EventNpzWriter&&) noexcept;
  EventNpzWriter& operator=(EventNpzWriter&&) noexcept;

  void write(std::span<const events::Event> events);  ///< coordinates must be >= 0. @throws Error if writing fails
  std::uint64_t steps_back() const;                   ///< in time, so far
  void close();                                       ///< completes the file; no further writes. @throws Error if writing fails

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::conversion
