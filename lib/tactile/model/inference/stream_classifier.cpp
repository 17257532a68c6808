#include "tactile/model/inference/stream_classifier.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::model {

StreamClassifier::StreamClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask,
                                   std::shared_ptr<const StreamNetwork> network)
    : sensor_(sensor), tick_(tick), mask_(sensor, mask), network_(std::move(network)), counts_(sensor, network_->grid()) {
  if (tick_ <= microseconds{0}) throw Error(fmt::format("a tick of {} us; expected more than 0", tick_.count()));
}

void StreamClassifier::add(std::span<const events::Event> events) {
  CameraTime last = last_;
  for (const events::Event& event : events) {
    if (event.t < last)
      throw Error(
          fmt::format("an event at {} us after one at {} us; expected events in order of time", us_of(event.t), us_of(last)));
    if (event.x < 0 || event.y < 0 || event.x >= sensor_.width || event.y >= sensor_.height)
      throw Error(fmt::format("an event at x {}, y {}; expected one on the sensor of {} x {} px", event.x, event.y, sensor_.width,
                              sensor_.height));
    last = event.t;
  }
  last_ = last;
  if (next_ == waiting_.size()) waiting_.clear(), next_ = 0;
  const std::span<const events::Event> counted = mask_.without(events, unmasked_);
  waiting_.insert(waiting_.end(), counted.begin(), counted.end());
}

void StreamClassifier::advance_to(CameraTime tick) {
  events_ = 0;
  counts_.clear();
  for (; next_ < waiting_.size() && waiting_[next_].t < tick; ++next_, ++events_) counts_.count(waiting_[next_]);
  network_->advance(counts_, state_);
  reached_ = tick;
}

void StreamClassifier::move_to(CameraTime tick) {
  if (tick < moved_to_)
    throw Error(
        fmt::format("a tick at {} us after one at {} us; expected ticks in order of time", us_of(tick), us_of(moved_to_)));
  if (us_of(tick) % tick_.count() != 0)
    throw Error(fmt::format("a tick at {} us; expected a whole number of {} us", us_of(tick), tick_.count()));
  moved_to_ = tick;
  while (true) {
    const bool has_event = next_ < waiting_.size() && waiting_[next_].t < tick;
    if (!reached_ && !has_event) break;
    // An event belongs to the first tick after it.
    const CameraTime with_event = has_event ? first_tick_from(waiting_[next_].t + microseconds{1}, tick_) : tick;
    CameraTime next = reached_ ? *reached_ + tick_ : with_event;
    if (state_.at_rest) next = std::max(next, with_event);
    if (next > tick) break;
    advance_to(next);
  }
  // A long queue loses what it no longer needs, without a copy at every tick.
  if (next_ > 4096 && 2 * next_ > waiting_.size()) {
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
  }
}

void StreamClassifier::restart() {
  counts_.clear();
  state_ = {};
  waiting_.clear();
  next_ = 0;
  events_ = 0;
  reached_.reset();
  moved_to_ = CameraTime::min();
  last_ = CameraTime::min();
}

}  // namespace tactile::model
