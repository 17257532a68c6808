#include "tactile/model/inference/tick_classifier.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::model {

TickClassifier::TickClassifier(events::SensorSize sensor, microseconds tick, const events::MaskPixels& mask)
    : sensor_(sensor), tick_(tick), mask_(mask), waiting_(sensor, mask) {
  if (tick_ <= microseconds{0}) throw Error(fmt::format("a tick of {} us; expected more than 0", tick_.count()));
}

void TickClassifier::move_to(CameraTime tick) {
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
    if (is_at_rest()) next = std::max(next, with_event);
    if (next > tick) break;
    logits_ = advance(waiting_.take_before(next), next);
    reached_ = next;
  }
}

void TickClassifier::restart() {
  waiting_ = events::WaitingEvents(sensor_, mask_);
  logits_ = {};
  reached_.reset();
  moved_to_ = CameraTime::min();
  forget();
}

}  // namespace tactile::model
