#include "tactile/detect/tick_clock.hpp"

#include <algorithm>

namespace tactile::detect {

void TickClock::restart() {
  line_.restart();
  first_event_.reset(), last_event_.reset(), last_reported_.reset();
  next_ = 0;
  arrivals_.clear();
}

std::size_t TickClock::too_late(std::span<const events::Event> events) const {
  if (!last_reported_ || events.empty() || events.front().t >= *last_reported_) return 0;
  const auto is_late = [this](const events::Event& event) { return event.t < *last_reported_; };
  return static_cast<std::size_t>(std::partition_point(events.begin(), events.end(), is_late) - events.begin());
}

void TickClock::arrived(CameraTime first, CameraTime last, HostTime at) {
  longest_packet_ = std::max(longest_packet_, between(first, last));
  if (!options_.by_events_alone) line_.add(last, at);
  if (!first_event_) {
    first_event_ = first;
    all_ = full_ticks(first, CameraTime::max(), options_.history, options_.tick);
  }
  last_event_ = last;
  const auto tick = next_tick();
  if (!tick || last < *tick) return;
  // A packet that closes no further tick is not needed.
  if (arrivals_.empty() || ticks_until(last).count > ticks_until(arrivals_.back().last).count) arrivals_.push_back({last, at});
}

TickRange TickClock::ticks_until(CameraTime t) const {
  if (!first_event_) return {.first = {}, .count = 0, .tick = options_.tick};
  return full_ticks(*first_event_, t, options_.history, options_.tick);
}

std::optional<CameraTime> TickClock::next_tick() const {
  if (!first_event_ || next_ >= all_.count) return std::nullopt;
  return all_.at(next_);
}

HostTime TickClock::closes_at(CameraTime tick) const {
  const microseconds slack = waits();
  const microseconds silence = std::max(microseconds{0}, between(*last_event_, tick));
  const std::int64_t wait = saturating_add(slack.count(), silence.count() / 10'000);
  return HostTime{microseconds{saturating_add(us_of(line_.host_of(tick)), wait)}};
}

std::optional<DueTick> TickClock::due(std::int64_t index, HostTime now) const {
  const CameraTime t = all_.at(index);
  DueTick tick{.t = t, .skipped = static_cast<std::uint64_t>(index - next_), .closed = {}, .by_events = true};
  const auto closing =
      std::find_if(arrivals_.begin(), arrivals_.end(), [t](const Arrival& arrival) { return arrival.last >= t; });
  std::optional<HostTime> by_host;
  if (host_closes()) by_host = closes_at(t);
  if (by_host && *by_host <= now && (closing == arrivals_.end() || *by_host < closing->at)) {
    tick.closed = *by_host;
    tick.by_events = false;
    return tick;
  }
  if (closing == arrivals_.end()) return std::nullopt;
  // The closing event may have waited to be read: then the host's time closed the tick earlier.
  tick.closed = std::min(closing->at, by_host.value_or(closing->at));
  return tick;
}

std::optional<DueTick> TickClock::next(HostTime now) const {
  if (!next_tick()) return std::nullopt;
  return due(next_, now);
}

std::optional<DueTick> TickClock::newest(HostTime now) const {
  if (!next_tick()) return std::nullopt;
  CameraTime until = *last_event_;
  if (host_closes()) until = std::max(until, line_.camera_of(now));
  std::int64_t index = std::min(all_.count, full_ticks(*first_event_, until, options_.history, options_.tick).count) - 1;
  // The host's time closes no tick before its slack is over: first go back by this many ticks.
  if (host_closes() && all_.at(std::max(index, next_)) > *last_event_) {
    const std::int64_t open =
        (waits() / options_.tick) + 1 + between(*last_event_, until).count() / 10'000 / options_.tick.count();
    const std::int64_t by_events = full_ticks(*first_event_, *last_event_, options_.history, options_.tick).count - 1;
    std::int64_t candidate = index;
    for (std::int64_t step = 0; step <= open + 1 && candidate > by_events && closes_at(all_.at(candidate)) > now; ++step)
      --candidate;
    index = candidate;
  }
  for (; index >= next_; --index) {
    if (const auto tick = due(index, now)) return tick;
  }
  return std::nullopt;
}

std::optional<HostTime> TickClock::next_by_host() const {
  const auto tick = next_tick();
  if (!tick || !host_closes()) return std::nullopt;
  return closes_at(*tick);
}

void TickClock::reported(const DueTick& tick) {
  next_ += static_cast<std::int64_t>(tick.skipped) + 1;
  last_reported_ = tick.t;
  const auto upcoming_tick = next_tick();
  const auto is_over = [&](const Arrival& arrival) { return !upcoming_tick || arrival.last < *upcoming_tick; };
  arrivals_.erase(arrivals_.begin(), std::find_if_not(arrivals_.begin(), arrivals_.end(), is_over));
}

}  // namespace tactile::detect
