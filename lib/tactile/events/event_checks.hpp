#pragma once

#include <optional>
#include <span>

#include "tactile/events/event.hpp"

namespace tactile::events {

/// Whether an event lies outside the sensor, or has a polarity that is neither 0 nor 1.
constexpr bool is_outside(const Event& e, SensorSize size) {
  return e.x < 0 || e.x >= size.width || e.y < 0 || e.y >= size.height || e.on > 1;
}

/// The allowed places of a stream's events: without a declared size, all that are not negative.
SensorSize bounds_of(const std::optional<SensorSize>& declared);

struct EventsCheck {
  bool inside = true;     ///< no event is outside
  bool ascending = true;  ///< no event is earlier than the one before it
};

/// Checks events without a branch per event, because nearly all are sound.
/// @param size  1 to 32768 pixels in each direction
EventsCheck check_events(std::span<const Event> events, SensorSize size);

/// Removes events outside the sensor, in place. @return  the others
std::span<Event> without_outside(std::span<Event> events, SensorSize size);

}  // namespace tactile::events
