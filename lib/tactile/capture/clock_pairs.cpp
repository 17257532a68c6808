#include "tactile/capture/clock_pairs.hpp"

#include <algorithm>
#include <utility>

namespace tactile::capture {
namespace {

std::int64_t difference(const ClockPair& pair) { return saturating_subtract(us_of(pair.host), us_of(pair.camera)); }

}  // namespace

void ClockPairs::take(const ClockPair& pair) {
  const auto period_of = [this](HostTime host) { return us_of(host) / period_.count(); };
  if (pairs_.empty() || period_of(pairs_.back().host) != period_of(pair.host)) {
    pairs_.push_back(pair);
  } else if (difference(pair) < difference(pairs_.back())) {
    pairs_.back() = pair;
  }
}

std::optional<ClockOffset> ClockPairs::offset() const {
  if (pairs_.empty()) return std::nullopt;
  // The last second may have only begun, so it may not have its smallest difference yet.
  const auto least_late = [this](std::size_t first) {
    const ClockPair &one = pairs_[first], &next = pairs_[std::min(first + 1, pairs_.size() - 1)];
    return difference(next) < difference(one) ? next : one;
  };
  const ClockPair first = least_late(0), last = least_late(pairs_.size() - std::min<std::size_t>(2, pairs_.size()));
  return ClockOffset{.offset = microseconds{difference(last)},
                     .change = microseconds{saturating_subtract(difference(last), difference(first))},
                     .span = microseconds{saturating_subtract(us_of(last.host), us_of(first.host))}};
}

void ClockPairs::add(CameraTime camera, HostTime host) {
  take({camera, host});
  while (pairs_.size() > limit_) {
    period_ *= 2;
    const std::vector<ClockPair> all = std::exchange(pairs_, {});
    for (const ClockPair& pair : all) take(pair);
  }
}

namespace {

constexpr microseconds window{100'000};

}  // namespace

microseconds RecentLateness::most(HostTime now) const {
  return now - begin_ < 2 * window ? std::max(before_, now_) : microseconds{0};
}

void RecentLateness::add(HostTime arrived, microseconds lateness) {
  if (arrived - begin_ >= window) {
    before_ = arrived - begin_ < 2 * window ? now_ : microseconds{0};
    now_ = microseconds{0};
    begin_ = arrived;
  }
  now_ = std::max(now_, lateness);
}

}  // namespace tactile::capture
