#include "tactile/alignment/activity.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tactile/alignment/moving_mean.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

std::size_t bins_in(microseconds span, const EventRate& rate) {
  return static_cast<std::size_t>(std::max<std::int64_t>(1, span / rate.bin));
}

/// Events per bin, this many standard deviations of sums over `width` bins above the quiet rate.
double limit_of(const QuietRate& quiet, std::size_t width, double deviations) {
  const double n = static_cast<double>(width), mean = quiet.mean * n;
  return (mean + deviations * std::sqrt(quiet.dispersion * std::max(mean, 1.0))) / n;
}

}  // namespace

QuietRate quiet_rate(const EventRate& rate) {
  const std::size_t width = bins_in(5ms, rate);
  std::vector<double> sums;
  for (std::size_t begin = 0; begin + width <= rate.counts.size(); begin += width) {
    double sum = 0;
    for (std::size_t i = begin; i < begin + width; ++i) sum += rate.counts[i];
    sums.push_back(sum);
  }
  const double middle = median(sums);
  const double deviation = sigma_per_median * median(distances_from(middle, sums));
  return {.mean = middle / static_cast<double>(width),
          .dispersion = std::max(1.0, deviation * deviation / std::max(middle, 1.0))};
}

double events_above(const EventRate& rate, const QuietRate& quiet, std::size_t begin, std::size_t end) {
  double events = 0;
  for (std::size_t i = begin; i < end; ++i) events += rate.counts[i] - quiet.mean;
  return events;
}

std::vector<Burst> bursts_in(const EventRate& rate, const QuietRate& quiet, const ActivityOptions& options) {
  const std::size_t width = bins_in(options.smoothing, rate);
  const std::vector<double> means = moving_mean(rate.counts, width);
  const double enter = limit_of(quiet, width, options.enter);
  const double leave = limit_of(quiet, width, options.leave);

  std::vector<Burst> bursts;
  for (std::size_t i = 0; i < means.size();) {
    if (means[i] < leave) {
      ++i;
      continue;
    }
    Burst burst{.begin = i, .end = i};
    double peak = 0;
    for (; i < means.size() && means[i] >= leave; ++i) {
      peak = std::max(peak, means[i]);
      burst.events += rate.counts[i] - quiet.mean;
    }
    burst.end = i;
    if (peak < enter) continue;
    if (!bursts.empty() && burst.begin - bursts.back().end < bins_in(options.merge, rate)) {
      bursts.back().end = burst.end;
      bursts.back().events += burst.events;
    } else {
      bursts.push_back(burst);
    }
  }
  std::erase_if(bursts, [&](const Burst& burst) { return burst.end - burst.begin < bins_in(options.shortest, rate); });
  return bursts;
}

bool is_after_effect(const Burst& burst, const EventRate& rate, std::span<const Burst> bursts) {
  constexpr microseconds brief = 40ms;
  constexpr double small = 0.1;
  double largest = 0;
  for (const Burst& other : bursts) largest = std::max(largest, other.events);
  return burst.end - burst.begin < bins_in(brief, rate) && burst.events < small * largest;
}

std::vector<Burst> without_after_effects(std::span<const Burst> bursts, const EventRate& rate) {
  std::vector<Burst> large;
  std::copy_if(bursts.begin(), bursts.end(), std::back_inserter(large),
               [&](const Burst& burst) { return !is_after_effect(burst, rate, bursts); });
  return large;
}

}  // namespace tactile::alignment
