#pragma once

#include <optional>
#include <span>

#include "tactile/events/event.hpp"

namespace tactile {

/// Whether an event lies outside the sensor, or has a polarity that is neither 0 nor 1.
constexpr bool is_outside(const Event& e, SensorSize size) {
  return e.x < 0 || e.x >= size.width || e.y < 0 || e.y >= size.height || e.on > 1;
}

/// The places that events of a stream may have: where it declares no size, all that are not negative.
SensorSize bounds_of(const std::optional<SensorSize>& declared);

struct EventsCheck {
  bool inside = true;     ///< no event is outside
  bool ascending = true;  ///< no event is earlier than the one before it
};

/// Looks through events without a branch for each: nearly all are sound.
/// @param size  1 to 32768 pixels each way
EventsCheck check_events(std::span<const Event> events, SensorSize size);

/// Drops those that are outside, in place; returns the others.
std::span<Event> without_outside(std::span<Event> events, SensorSize size);

}  // namespace tactile
