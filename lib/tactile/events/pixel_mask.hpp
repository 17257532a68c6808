#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::events {

/// Pixels of a sensor whose events do not count. Empty: all count.
///
/// Its file is a table of comma-separated values with the columns `x` and `y` (others are passed over), one pixel a row.
class PixelMask {
 public:
  PixelMask() = default;
  /// @param pixels  any order; the same pixel may be there twice
  /// @throws Error  names `where`, if a pixel lies outside the sensor
  PixelMask(SensorSize size, std::span<const std::pair<int, int>> pixels, const std::string& where);

  bool empty() const { return pixels_.empty(); }
  SensorSize size() const { return size_; }
  const std::vector<std::pair<int, int>>& pixels() const { return pixels_; }  ///< x, y, by row, each once
  /// SHA-256 of the pixels, "x,y\n" in this order; empty of an empty mask.
  const std::string& sha256() const { return sha256_; }

  bool covers(const Event& event) const {
    return !covered_.empty() && event.x >= 0 && event.y >= 0 && event.x < size_.width && event.y < size_.height &&
           covered_[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) +
                    static_cast<std::size_t>(event.x)];
  }

  /// The events that count, in their order; `kept` is overwritten unless the mask is empty.
  std::span<const Event> without(std::span<const Event> events, std::vector<Event>& kept) const;

 private:
  SensorSize size_;
  std::vector<std::pair<int, int>> pixels_;
  std::vector<bool> covered_;
  std::string sha256_;
};

/// @throws Error  if the file cannot be read, lacks a column, has a cell that is no whole number, or a pixel outside the sensor
PixelMask read_pixel_mask(const std::filesystem::path& file, SensorSize size);

/// The pixels of a mask's file, whatever the sensor. @throws Error  as `read_pixel_mask`; also a pixel below 0 or above 32767
std::vector<std::pair<int, int>> read_mask_pixels(const std::filesystem::path& file);

}  // namespace tactile::events
