#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "tactile/events/event.hpp"

namespace tactile {

/// Drops, in place, what lies outside the sensor (at a negative place, where its size is unknown) or has a polarity above 1;
/// returns what is left, at the front. The first pass looks without a branch, for most packets are sound.
inline std::span<Event> sound_events(std::span<Event> events, const std::optional<SensorSize>& size) {
  constexpr int most = std::numeric_limits<std::int16_t>::max() + 1;
  const SensorSize sensor = size.value_or(SensorSize{.width = most, .height = most});
  const auto width = static_cast<std::uint32_t>(std::min(sensor.width, most));
  const auto height = static_cast<std::uint32_t>(std::min(sensor.height, most));
  const auto is_bad = [=](const Event& e) {
    return (static_cast<std::uint16_t>(e.x) >= width) | (static_cast<std::uint16_t>(e.y) >= height) | (e.on > 1);
  };
  unsigned bad = 0;
  for (const Event& event : events) bad |= static_cast<unsigned>(is_bad(event));
  if (bad == 0) return events;
  const auto kept_end = std::remove_if(events.begin(), events.end(), is_bad);
  return events.first(static_cast<std::size_t>(kept_end - events.begin()));
}

}  // namespace tactile
