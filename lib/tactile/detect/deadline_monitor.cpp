#include "tactile/detect/deadline_monitor.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tactile::detect {

using std::chrono::nanoseconds;

/// Each nanosecond below `steps` has its own bin; above, each octave has `steps` bins.
std::size_t DurationHistogram::bin_of(std::uint64_t ns) {
  if (ns < steps) return ns;
  const auto octave = static_cast<unsigned>(std::bit_width(ns)) - static_cast<unsigned>(std::bit_width(steps));
  return std::min<std::size_t>(bins - 1, steps * (octave + 1) + ((ns >> octave) - steps));
}

/// The last value of a bin.
std::uint64_t DurationHistogram::end_of(std::size_t bin) {
  if (bin < steps) return bin;
  const std::size_t octave = bin / steps - 1;
  return ((bin % steps + steps + 1) << octave) - 1;
}

void DurationHistogram::add(nanoseconds duration) {
  duration = std::max(duration, nanoseconds{0});
  ++counts_[bin_of(static_cast<std::uint64_t>(duration.count()))];
  ++count_;
  sum_ns_ += static_cast<double>(duration.count());
  max_ = std::max(max_, duration);
}

double DurationHistogram::mean_us() const { return count_ > 0 ? 1e-3 * sum_ns_ / static_cast<double>(count_) : 0; }

nanoseconds DurationHistogram::percentile(double share) const {
  if (count_ == 0) return nanoseconds{0};
  const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_))));
  std::uint64_t sum = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    sum += counts_[bin];
    if (sum >= wanted) return std::min(max_, nanoseconds{static_cast<std::int64_t>(end_of(bin))});
  }
  return max_;
}

std::vector<DurationHistogram::Bin> DurationHistogram::octaves() const {
  std::vector<Bin> octaves;
  std::size_t last = 0;
  for (std::size_t first = 0; first < bins; first += steps) {
    std::uint64_t count = 0;
    for (std::size_t bin = first; bin < first + steps; ++bin) count += counts_[bin];
    if (count == 0 && octaves.empty()) continue;
    const double from = first == 0 ? 0 : 1e-3 * static_cast<double>(end_of(first - 1) + 1);
    octaves.push_back({from, 1e-3 * static_cast<double>(end_of(first + steps - 1) + 1), count});
    if (count > 0) last = octaves.size();
  }
  octaves.resize(last);
  return octaves;
}

void to_json(nlohmann::json& json, const DurationHistogram& histogram) {
  if (histogram.count() == 0) {
    json = nullptr;
    return;
  }
  const auto us = [](nanoseconds ns) { return 1e-3 * static_cast<double>(ns.count()); };
  json = {
      {"p50", us(histogram.percentile(0.5))}, {"p99", us(histogram.percentile(0.99))}, {"p999", us(histogram.percentile(0.999))},
      {"max", us(histogram.max())},           {"mean", histogram.mean_us()},           {"count", histogram.count()}};
}

double DeadlineMonitor::Counts::missed_share() const {
  const std::uint64_t all = reported + skipped;
  return all > 0 ? static_cast<double>(missed()) / static_cast<double>(all) : 0;
}

void DeadlineMonitor::add(const TickTimes& times, std::uint64_t skipped) {
  ++counts_.reported;
  counts_.skipped += skipped;
  const nanoseconds work = times.rendering + times.network + times.output;
  rendering_.add(times.rendering);
  network_.add(times.network);
  output_.add(times.output);
  work_.add(work);
  if (times.waiting) waiting_.add(*times.waiting);
  if (!times.queued) return;
  queued_.add(*times.queued);
  answer_.add(*times.queued + work);
  if (*times.queued + work > tick_) ++counts_.late;
  if (times.waiting) whole_.add(*times.waiting + *times.queued + work);
}

}  // namespace tactile::detect
