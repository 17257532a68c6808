#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::events {

/// x, y of pixels, by row, each once.
using MaskPixels = std::vector<std::pair<int, int>>;

/// The pixels in the order of `MaskPixels`.
MaskPixels ordered(MaskPixels pixels);

/// Pixels of a sensor whose events do not count. Empty: all count.
///
/// Its file is a table of comma-separated values with the columns `x` and `y` (others are passed over), one pixel a row.
class PixelMask {
 public:
  PixelMask() = default;
  /// @param pixels  in any order
  /// @throws Error  if a pixel lies outside the sensor; it begins with `where`
  PixelMask(SensorSize size, MaskPixels pixels, const std::string& where = "mask");

  bool empty() const { return pixels_.empty(); }
  const MaskPixels& pixels() const { return pixels_; }

  bool covers(const Event& event) const {
    return !covered_.empty() && event.x >= 0 && event.y >= 0 && event.x < size_.width && event.y < size_.height &&
           covered_[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) +
                    static_cast<std::size_t>(event.x)];
  }

  /// The events that count, in their order; `kept` is overwritten unless the mask is empty.
  std::span<const Event> without(std::span<const Event> events, std::vector<Event>& kept) const;

 private:
  SensorSize size_;
  MaskPixels pixels_;
  std::vector<bool> covered_;
};

/// The pixels of a mask's file. @throws Error  if it cannot be read, lacks a column, or has a cell that is no whole number from 0
/// to 32767
MaskPixels read_mask(const std::filesystem::path& file);

}  // namespace tactile::events
