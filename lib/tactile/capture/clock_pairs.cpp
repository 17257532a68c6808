#include "tactile/capture/clock_pairs.hpp"

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

void ClockPairs::add(CameraTime camera, HostTime host) {
  take({camera, host});
  while (pairs_.size() > limit_) {
    period_ *= 2;
    const std::vector<ClockPair> all = std::exchange(pairs_, {});
    for (const ClockPair& pair : all) take(pair);
  }
}

}  // namespace tactile::capture
