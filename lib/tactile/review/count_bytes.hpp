#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "tactile/events/event.hpp"

// Pictures of counts as the pages take them: a header of four uint32, little-endian, then bytes.
namespace tactile::review {

/// Counts events by pixel and polarity.
class CountBytes {
 public:
  explicit CountBytes(events::SensorSize size);

  void add(std::span<const events::Event> events);  ///< those outside the sensor do not count

  /// The header is width, height, events on and off. Then comes a byte for each pixel, the number of its events on, 255 at most;
  /// then the same of those off.
  std::string bytes() const;

 private:
  events::SensorSize size_;
  std::string planes_;
  std::uint64_t on_ = 0, off_ = 0;
};

/// The header is width, height, events and 0. Then comes a byte for each cell.
std::string heatmap_bytes(events::SensorSize size, std::uint64_t events, std::span<const std::uint8_t> heatmap);

}  // namespace tactile::review
