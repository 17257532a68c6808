#include "tactile/events/waiting_events.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"

namespace tactile::events {

WaitingEvents::WaitingEvents(SensorSize sensor, const MaskPixels& mask) : sensor_(sensor), mask_(sensor, mask) {
  if (sensor.width < 1 || sensor.height < 1 || std::max(sensor.width, sensor.height) > most_side)
    throw Error(fmt::format("a sensor of {} x {} px; expected sides of 1 to {}", sensor.width, sensor.height, most_side));
}

void WaitingEvents::add(std::span<const Event> events) {
  CameraTime last = last_;
  for (const Event& event : events) {
    if (event.t < last)
      throw Error(
          fmt::format("an event at {} us after one at {} us; expected events in order of time", us_of(event.t), us_of(last)));
    if (event.x < 0 || event.y < 0 || event.x >= sensor_.width || event.y >= sensor_.height)
      throw Error(fmt::format("an event at x {}, y {}; expected one on the sensor of {} x {} px", event.x, event.y, sensor_.width,
                              sensor_.height));
    last = event.t;
  }
  last_ = last;
  // A long queue loses what it no longer needs, without a copy at every tick.
  if (next_ == waiting_.size() || (next_ > 4096 && 2 * next_ > waiting_.size())) {
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
  }
  const std::span<const Event> counted = mask_.without(events, unmasked_);
  waiting_.insert(waiting_.end(), counted.begin(), counted.end());
}

std::optional<CameraTime> WaitingEvents::next() const {
  return next_ < waiting_.size() ? std::optional(waiting_[next_].t) : std::nullopt;
}

std::span<const Event> WaitingEvents::take_before(CameraTime t) {
  const std::size_t first = next_;
  while (next_ < waiting_.size() && waiting_[next_].t < t) ++next_;
  return std::span(waiting_).subspan(first, next_ - first);
}

}  // namespace tactile::events
