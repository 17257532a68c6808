#pragma once

#include <span>

#include "tactile/events/event.hpp"

namespace tactile {

struct EventsCheck {
  bool inside = true;     ///< 0 <= x < width, 0 <= y < height and a polarity of 0 or 1, of every event
  bool ascending = true;  ///< no event is earlier than the one before it
};

/// Looks through events without a branch for each: nearly all are sound.
/// @param size  1 to 32768 pixels each way
EventsCheck check_events(std::span<const Event> events, SensorSize size);

}  // namespace tactile
