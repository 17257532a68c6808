#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::conversion {

/// A rectangle of pixels. After a crop, coordinates count from its upper left corner.
struct PixelRegion {
  int x = 0, y = 0;           ///< of its upper left corner, from the left, from the top [px] >= 0
  int width = 0, height = 0;  ///< [px] > 0

  friend bool operator==(const PixelRegion&, const PixelRegion&) = default;
};

/// Appends the events inside the region to `kept`, with coordinates that count from its corner.
void crop_events(std::span<const events::Event> events, const PixelRegion& region, std::vector<events::Event>& kept);

/// The part of the frame inside the region, with a position that counts from the region's corner; nothing if they do not overlap.
/// @param bytes_per_pixel  of the frame's format
std::optional<events::Frame> cropped(const events::Frame& frame, const PixelRegion& region, std::size_t bytes_per_pixel);

}  // namespace tactile::conversion
