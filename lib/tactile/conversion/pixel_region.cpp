#include "tactile/conversion/pixel_region.hpp"

#include <algorithm>

namespace tactile::conversion {

void crop_events(std::span<const events::Event> events, const PixelRegion& region, std::vector<events::Event>& kept) {
  for (const events::Event& event : events) {
    const int x = event.x - region.x, y = event.y - region.y;
    if (x < 0 || y < 0 || x >= region.width || y >= region.height) continue;
    events::Event moved = event;
    moved.x = static_cast<std::int16_t>(x);
    moved.y = static_cast<std::int16_t>(y);
    kept.push_back(moved);
  }
}

std::optional<events::Frame> cropped(const events::Frame& frame, const PixelRegion& region, std::size_t bytes_per_pixel) {
  const int left = std::max<int>(frame.position_x, region.x), top = std::max<int>(frame.position_y, region.y);
  const int right = std::min(frame.position_x + frame.width, region.x + region.width);
  const int bottom = std::min(frame.position_y + frame.height, region.y + region.height);
  if (left >= right || top >= bottom) return std::nullopt;

  events::Frame part{.t = frame.t,
                     .frame_start = frame.frame_start,
                     .frame_end = frame.frame_end,
                     .exposure_start = frame.exposure_start,
                     .exposure_end = frame.exposure_end,
                     .format = frame.format,
                     .width = static_cast<std::int16_t>(right - left),
                     .height = static_cast<std::int16_t>(bottom - top),
                     .position_x = static_cast<std::int16_t>(left - region.x),
                     .position_y = static_cast<std::int16_t>(top - region.y),
                     .pixels = {}};
  const std::size_t row = static_cast<std::size_t>(frame.width) * bytes_per_pixel;
  const std::size_t skipped = static_cast<std::size_t>(left - frame.position_x) * bytes_per_pixel;
  const std::size_t kept = static_cast<std::size_t>(part.width) * bytes_per_pixel;
  part.pixels.reserve(kept * static_cast<std::size_t>(part.height));
  for (int y = top - frame.position_y; y < bottom - frame.position_y; ++y) {
    const auto begin = frame.pixels.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row + skipped);
    part.pixels.insert(part.pixels.end(), begin, begin + static_cast<std::ptrdiff_t>(kept));
  }
  return part;
}

}  // namespace tactile::conversion
