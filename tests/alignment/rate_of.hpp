#pragma once

#include <functional>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/core/random.hpp"

namespace tactile::test {

/// A Poisson event rate of `rate_at(t in us)` events per 200 us bin, `bins` long, from camera time 1 s on.
inline alignment::EventRate rate_of(std::size_t bins, const std::function<double(double)>& rate_at, std::uint64_t seed) {
  Random random(seed);
  alignment::EventRate rate;
  rate.begin = camera_time(1'000'000);
  rate.bin = 200us;
  for (std::size_t i = 0; i < bins; ++i)
    rate.counts.push_back(static_cast<std::uint32_t>(random.poisson(rate_at((static_cast<double>(i) + 0.5) * 200.0))));
  rate.last = rate.begin_of(bins);
  return rate;
}

}  // namespace tactile::test
