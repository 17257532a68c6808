#include "tactile/core/clock_pairs.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace tactile {
namespace {

template <class Clock>
std::int64_t difference(const ClockPair<Clock>& pair) {
  return saturating_subtract(us_of(pair.host), us_of(pair.device));
}

}  // namespace

template <class Clock>
void ClockPairs<Clock>::take(const ClockPair<Clock>& pair) {
  const auto period_of = [this](HostTime host) { return us_of(host) / period_.count(); };
  if (pairs_.empty() || period_of(pairs_.back().host) != period_of(pair.host)) {
    pairs_.push_back(pair);
  } else if (difference(pair) < difference(pairs_.back())) {
    pairs_.back() = pair;
  }
}

template <class Clock>
std::optional<ClockOffset> ClockPairs<Clock>::offset() const {
  if (pairs_.empty()) return std::nullopt;
  // The last second may have only begun, so it may not have its smallest difference yet.
  const auto least_late = [this](std::size_t first) {
    const ClockPair<Clock>&one = pairs_[first], &next = pairs_[std::min(first + 1, pairs_.size() - 1)];
    return difference(next) < difference(one) ? next : one;
  };
  const ClockPair<Clock> first = least_late(0), last = least_late(pairs_.size() - std::min<std::size_t>(2, pairs_.size()));
  return ClockOffset{.offset = microseconds{difference(last)},
                     .change = microseconds{saturating_subtract(difference(last), difference(first))},
                     .span = microseconds{saturating_subtract(us_of(last.host), us_of(first.host))}};
}

template <class Clock>
void ClockPairs<Clock>::add(const ClockPair<Clock>& pair) {
  take(pair);
  while (pairs_.size() > limit_) {
    period_ *= 2;
    const std::vector<ClockPair<Clock>> all = std::exchange(pairs_, {});
    for (const ClockPair<Clock>& kept : all) take(kept);
  }
}

template class ClockPairs<CameraClock>;
template class ClockPairs<RobotClock>;
template class ClockPairs<VideoClock>;

}  // namespace tactile
