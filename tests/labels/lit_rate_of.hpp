#pragma once

#include <functional>

#include "alignment/rate_of.hpp"
#include "tactile/labels/lit_rate.hpp"

namespace tactile::test {

/// The rate of `rate_of` as that of what a burst from bin `burst_begin` to `burst_end` lights, with a known quiet rate.
inline labels::LitRate lit_rate_of(std::size_t bins, const std::function<double(double)>& rate_at, std::uint64_t seed,
                                   std::size_t burst_begin, std::size_t burst_end, double quiet_per_bin) {
  labels::LitRate lit;
  lit.rate = rate_of(bins, rate_at, seed);
  lit.quiet_per_bin = quiet_per_bin;
  lit.burst_begin = burst_begin;
  lit.burst_end = burst_end;
  return lit;
}

}  // namespace tactile::test
