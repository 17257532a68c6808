#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "tactile/core/time.hpp"

namespace tactile::events {

/// One change of brightness at one pixel, laid out as AEDAT4 stores it, so that a packet is read in place.
struct Event {
  CameraTime t;         ///< read-out time; every event of one read-out shares it
  std::int16_t x = 0;   ///< from the left [px]
  std::int16_t y = 0;   ///< from the top [px]
  std::uint8_t on = 0;  ///< 1 brighter, 0 darker
  std::uint8_t padding[3] = {};

  friend bool operator==(const Event& a, const Event& b) { return a.t == b.t && a.x == b.x && a.y == b.y && a.on == b.on; }
};
static_assert(sizeof(Event) == 16 && alignof(Event) == 8 && std::is_trivially_copyable_v<Event>);

/// Recordings, bags and options may declare no wider and no higher sensor.
constexpr int most_side = std::numeric_limits<std::int16_t>::max();  ///< [px]

struct SensorSize {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]

  friend bool operator==(const SensorSize&, const SensorSize&) = default;
};

}  // namespace tactile::events
