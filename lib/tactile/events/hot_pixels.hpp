#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::events {

/// When a pixel is hot: it fires by itself, whatever the scene does. An absolute rate does not decide: a read-out of 200 us
/// allows at most 5000 events/s, and a trembling edge reaches hundreds. A pixel with n events in a recording of length T is hot
/// if all of these hold:
///
///   n >= over_median * m        m = median count of the pixels that fired; 1 if fewer than 1 % of the pixels fired
///   n >= over_neighbours * n2   n2 = second largest count among the 24 pixels around it: edges are rows of pixels, hot pixels
///                               are single or in pairs
///   n >= min_events
///   n / T >= min_rate_hz
struct HotPixelRule {
  double over_median = 10;
  double over_neighbours = 5;
  double min_rate_hz = 50;
  std::uint32_t min_events = 30;
};

struct HotPixel {
  int x = 0, y = 0;
  std::uint32_t events = 0;
  double rate_hz = 0;
};

/// The hot pixels of a recording.
struct HotPixels {
  std::vector<HotPixel> pixels;  ///< sorted by events, most first
  std::uint64_t fired = 0;       ///< pixels with an event
  double least_events = 0;       ///< a hot pixel has at least this many, by all conditions but that on its neighbours
};

/// @param counts   events per pixel, row by row, of a sensor of this size
/// @param seconds  length of the recording; without a length no pixel is hot
HotPixels find_hot_pixels(std::span<const std::uint32_t> counts, SensorSize size, double seconds, const HotPixelRule& rule = {});

}  // namespace tactile::events
