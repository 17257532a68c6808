#include "tactile/review/rate_counts.hpp"

#include <algorithm>
#include <cassert>

namespace tactile::review {
namespace {

constexpr double us_per_ms = 1000;

}  // namespace

RateCounts::RateCounts(CameraTime first, CameraTime last, microseconds bin) : first_(first), bin_(bin) {
  const std::int64_t span = std::max<std::int64_t>(0, between(first, last).count());
  while (static_cast<std::uint64_t>(span / bin_.count()) + 1 > most_bins) bin_ *= 2;
  counts_.resize(static_cast<std::size_t>(span / bin_.count()) + 1);
}

void RateCounts::add(std::span<const events::Event> events) {
  for (const events::Event& event : events) {
    const std::int64_t since = between(first_, event.t).count();
    if (since < 0) continue;
    const auto at = static_cast<std::size_t>(since / bin_.count());
    if (at < counts_.size()) ++counts_[at];
  }
}

void RateCounts::finish() {
  std::uint64_t events = 0;
  before_.clear();
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (i % stride == 0) before_.push_back(events);
    events += counts_[i];
  }
  before_.push_back(events);  // for a whole number of strides
}

std::uint64_t RateCounts::events_before(std::size_t bin_index) const {
  assert(bin_index <= counts_.size());
  std::uint64_t events = before_[bin_index / stride];
  for (std::size_t i = bin_index - bin_index % stride; i < bin_index; ++i) events += counts_[i];
  return events;
}

SignalWindow RateCounts::window(const WindowRequest& request) const {
  SignalWindow window;
  window.bucket_us = request.bucket_us(bin_.count());
  const std::int64_t per_bucket = window.bucket_us / bin_.count(), all = static_cast<std::int64_t>(counts_.size());
  const std::int64_t over = std::max(per_bucket, request.smooth_us / bin_.count());
  window.over_us = over * bin_.count();
  const double bin_ms = static_cast<double>(bin_.count()) / us_per_ms;
  for (std::int64_t k = std::max<std::int64_t>(0, request.from_us / window.bucket_us);
       k * window.bucket_us < request.to_us && k * per_bucket < all; ++k) {
    const std::int64_t around = k * per_bucket - (over - per_bucket) / 2;
    const std::int64_t begin = std::max<std::int64_t>(0, around), end = std::min(around + over, all);
    const std::uint64_t events = events_in(static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
    const double rate = static_cast<double>(events) / (bin_ms * static_cast<double>(end - begin));
    window.add(k * window.bucket_us + window.bucket_us / 2, rate, rate, rate);
  }
  return window;
}

RateCounts::Busiest RateCounts::busiest(microseconds length) const {
  const std::size_t bins = std::clamp<std::size_t>(static_cast<std::size_t>(length / bin_), 1, counts_.size());
  Busiest busiest;
  std::uint64_t events = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    events += counts_[i];
    if (i >= bins) events -= counts_[i - bins];
    if (events > busiest.events) busiest = {events, i + 1 >= bins ? i + 1 - bins : 0};
  }
  return busiest;
}

}  // namespace tactile::review
