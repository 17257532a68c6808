#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tactile/characterise/sensor.hpp"

namespace tactile::characterise {

/// Events per pixel of all quiet recordings together.
struct PixelCounts {
  events::SensorSize size;
  std::vector<std::uint32_t> on, off;  ///< y * width + x
  double seconds = 0;
  double period_us = 0;  ///< of the read-outs, 0 if they have none

  std::size_t pixels() const { return on.size(); }
  /// @param place  an event or a pixel
  template <class Place>
  std::size_t index_of(const Place& place) const {
    return static_cast<std::size_t>(place.y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(place.x);
  }
  double events(std::size_t pixel) const { return static_cast<double>(on[pixel]) + off[pixel]; }
};

/// Stuck, hot and warm pixels; `regularity` is measured later.
/// @param lit  by pixel, those that light makes fire, if they are known
UnusualPixels unusual_pixels(const PixelCounts& counts, const std::vector<bool>& lit = {});

/// By pixel: none of the unusual ones.
std::vector<bool> ordinary_pixels(const PixelCounts& counts, const UnusualPixels& unusual);

/// Between pixels, standard deviation of the share of ON events beyond what chance gives: with n events, k of them ON, share p
/// of all,  sum ((k - n p)^2 - n p (1 - p)) / sum n (n - 1).
Measured on_spread(const PixelCounts& counts, const std::vector<bool>& ordinary);

/// Quantiles of the rates of ordinary pixels at 101 equal steps from 0 to 1 [1/s].
std::vector<double> rate_quantiles(const PixelCounts& counts, const std::vector<bool>& ordinary);

}  // namespace tactile::characterise
