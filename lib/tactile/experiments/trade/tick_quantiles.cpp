#include "tactile/experiments/trade/tick_quantiles.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::trade {

TickQuantiles::TickQuantiles(std::span<const TimedRun> runs) {
  for (std::uint32_t run = 0; run < runs.size(); ++run) {
    for (const float us : runs[run].tick_us) ticks_.push_back({us, run});
    counts_.push_back(runs[run].tick_us.size());
  }
  std::sort(ticks_.begin(), ticks_.end(), [](const Tick& a, const Tick& b) { return a.us < b.us; });
}

std::optional<double> TickQuantiles::of(std::span<const std::uint32_t> weights, double q) const {
  std::uint64_t total = 0;
  for (std::size_t run = 0; run < counts_.size(); ++run) total += weights[run] * counts_[run];
  if (total == 0) return std::nullopt;
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(total))));
  std::uint64_t passed = 0;
  // High quantiles are near the end: the walk from there is short.
  if (2 * rank > total) {
    return std::find_if(ticks_.rbegin(), ticks_.rend(),
                        [&](const Tick& tick) {
                          passed += weights[tick.run];
                          return passed > total - rank;
                        })
        ->us;
  }
  for (const Tick& tick : ticks_) {
    passed += weights[tick.run];
    if (passed >= rank) return tick.us;
  }
  return std::nullopt;
}

std::optional<double> TickQuantiles::of(const evaluation::RunsByObject& drawn, double q) const {
  std::vector<std::uint32_t> weights(counts_.size(), 0);
  for (const auto& object : drawn) {
    for (const std::size_t run : object) ++weights[run];
  }
  return of(weights, q);
}

}  // namespace tactile::trade
