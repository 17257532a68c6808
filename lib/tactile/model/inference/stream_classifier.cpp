#include "tactile/model/inference/stream_classifier.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::model {

StreamClassifier::StreamClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask,
                                   std::shared_ptr<const StreamNetwork> network)
    : sensor_(sensor),
      tick_(tick),
      mask_(mask),
      network_(std::move(network)),
      waiting_(sensor, mask),
      counts_(sensor, network_->grid()) {
  if (tick_ <= microseconds{0}) throw Error(fmt::format("a tick of {} us; expected more than 0", tick_.count()));
}

void StreamClassifier::advance_to(CameraTime tick) {
  const std::span<const events::Event> taken = waiting_.take_before(tick);
  counts_.clear();
  for (const events::Event& event : taken) counts_.count(event);
  network_->advance(counts_, state_);
  events_ = taken.size();
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
    const std::optional<CameraTime> event = waiting_.next();
    const bool has_event = event && *event < tick;
    if (!reached_ && !has_event) break;
    // An event belongs to the first tick after it.
    const CameraTime with_event = has_event ? first_tick_from(*event + microseconds{1}, tick_) : tick;
    CameraTime next = reached_ ? *reached_ + tick_ : with_event;
    if (state_.at_rest) next = std::max(next, with_event);
    if (next > tick) break;
    advance_to(next);
  }
}

void StreamClassifier::restart() {
  waiting_ = events::WaitingEvents(sensor_, mask_);
  counts_.clear();
  state_ = {};
  events_ = 0;
  reached_.reset();
  moved_to_ = CameraTime::min();
}

}  // namespace tactile::model
