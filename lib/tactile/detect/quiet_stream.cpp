#include "tactile/detect/quiet_stream.hpp"

#include <algorithm>

namespace tactile::detect {
namespace {

constexpr microseconds period{250'000};
constexpr std::uint64_t most_events_per_tick = 256;  // counting them takes some microseconds

}  // namespace

void QuietStream::forget() { period_begin_ = {}, last_period_.reset(), this_period_.reset(); }

void QuietStream::packet(std::uint64_t events, bool knows_arrival) {
  events_since_tick_ += events;
  if (events_since_tick_ > most_events_per_tick || !knows_arrival) forget();
}

void QuietStream::tick(microseconds waited, HostTime closed) {
  if (!this_period_ || closed - period_begin_ >= period) {
    last_period_ = closed - period_begin_ < 2 * period ? this_period_ : std::nullopt;
    this_period_ = waited, period_begin_ = closed;
  }
  this_period_ = std::min(*this_period_, waited);
}

std::optional<microseconds> QuietStream::least_waiting(HostTime now) const {
  if (!last_period_ || !this_period_ || now - period_begin_ > 2 * period) return std::nullopt;
  return std::min(*last_period_, *this_period_);
}

}  // namespace tactile::detect
