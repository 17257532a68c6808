#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile {

/// A rectangle of pixels; what lies in it is counted from its upper left corner once it is cut out.
struct PixelRegion {
  int x = 0, y = 0;           ///< of its upper left corner, from the left, from the top [px] >= 0
  int width = 0, height = 0;  ///< [px] > 0

  friend bool operator==(const PixelRegion&, const PixelRegion&) = default;
};

/// Appends those of `events` that lie in the region to `kept`, their places counted from its corner.
void crop_events(std::span<const Event> events, const PixelRegion& region, std::vector<Event>& kept);

/// The part of the frame that lies in the region, its position counted from the region's corner; nothing if none does.
/// `bytes_per_pixel` of its format.
std::optional<Frame> cropped(const Frame& frame, const PixelRegion& region, std::size_t bytes_per_pixel);

}  // namespace tactile
