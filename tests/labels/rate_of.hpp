#pragma once

#include <functional>

#include "tactile/core/random.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/labels/lit_rate.hpp"

namespace tactile::test {

/// A Poisson event rate of `rate_at(t in us)` events per 200 us bin, `bins` long, from camera time 1 s on.
inline EventRate rate_of(std::size_t bins, const std::function<double(double)>& rate_at, std::uint64_t seed) {
  Random random(seed);
  EventRate rate;
  rate.begin = camera_time(1'000'000);
  rate.bin = 200us;
  for (std::size_t i = 0; i < bins; ++i)
    rate.counts.push_back(static_cast<std::uint32_t>(random.poisson(rate_at((static_cast<double>(i) + 0.5) * 200.0))));
  rate.last = rate.begin_of(bins);
  return rate;
}

/// Likewise as the rate of what a burst from bin `burst_begin` to `burst_end` lights, with a known quiet rate.
inline LitRate lit_rate_of(std::size_t bins, const std::function<double(double)>& rate_at, std::uint64_t seed,
                           std::size_t burst_begin, std::size_t burst_end, double quiet_per_bin) {
  LitRate lit;
  lit.rate = rate_of(bins, rate_at, seed);
  lit.quiet_per_bin = quiet_per_bin;
  lit.burst_begin = burst_begin;
  lit.burst_end = burst_end;
  return lit;
}

}  // namespace tactile::test
