#include "tactile/review/rate_levels.hpp"

#include <algorithm>
#include <cassert>

namespace tactile::review {
namespace {

constexpr double us_per_ms = 1000;

/// The bucket that holds `t`, also before the first event.
std::int64_t multiple_below(std::int64_t t, std::int64_t length) { return t / length - (t % length < 0 ? 1 : 0); }

}  // namespace

RateLevels::RateLevels(CameraTime first, CameraTime last) : first_(first), bin_(finest) {
  const std::int64_t span = std::max<std::int64_t>(0, between(first, last).count());
  while (static_cast<std::uint64_t>(span / bin_.count()) + 1 > most_bins) bin_ *= 2;
  counts_.resize(static_cast<std::size_t>(span / bin_.count()) + 1);
}

void RateLevels::add(std::span<const events::Event> events) {
  for (const events::Event& event : events) {
    const std::int64_t since = between(first_, event.t).count();
    if (since < 0) continue;
    const auto at = static_cast<std::size_t>(since / bin_.count());
    if (at < counts_.size()) ++counts_[at];
  }
}

void RateLevels::finish() {
  levels_.clear();
  for (std::size_t below = counts_.size(); below > ratio;) {
    const Level* finer = levels_.empty() ? nullptr : &levels_.back();
    const std::size_t size = (below + ratio - 1) / ratio;
    Level level{std::vector<std::uint64_t>(size), std::vector<std::uint32_t>(size, UINT32_MAX), std::vector<std::uint32_t>(size)};
    for (std::size_t i = 0; i < below; ++i) {
      level.events[i / ratio] += finer ? finer->events[i] : counts_[i];
      level.least[i / ratio] = std::min(level.least[i / ratio], finer ? finer->least[i] : counts_[i]);
      level.most[i / ratio] = std::max(level.most[i / ratio], finer ? finer->most[i] : counts_[i]);
    }
    levels_.push_back(std::move(level));
    below = size;
  }
}

RateLevels::Sum RateLevels::over(std::size_t begin, std::size_t end) const {
  assert(begin < end && end <= counts_.size());
  Sum sum{.events = 0, .least = UINT32_MAX, .most = 0};
  const auto take = [&](std::size_t depth, std::size_t i) {
    const bool is_finest = depth == 0;
    sum.events += is_finest ? counts_[i] : levels_[depth - 1].events[i];
    sum.least = std::min(sum.least, is_finest ? counts_[i] : levels_[depth - 1].least[i]);
    sum.most = std::max(sum.most, is_finest ? counts_[i] : levels_[depth - 1].most[i]);
  };
  // At each level the bins at both ends that fill no coarser one; the middle goes up.
  for (std::size_t depth = 0; begin < end; ++depth) {
    const bool is_coarsest = depth == levels_.size();
    while (begin < end && (is_coarsest || begin % ratio != 0)) take(depth, begin++);
    while (begin < end && end % ratio != 0) take(depth, --end);
    begin /= ratio;
    end /= ratio;
  }
  return sum;
}

SignalWindow RateLevels::window(const WindowRequest& request) const {
  SignalWindow window;
  window.bucket_us = request.bucket_us(bin_.count());
  const std::int64_t per_bucket = window.bucket_us / bin_.count(), all = static_cast<std::int64_t>(counts_.size());
  const double bin_ms = static_cast<double>(bin_.count()) / us_per_ms;
  for (std::int64_t k = std::max<std::int64_t>(0, multiple_below(request.from_us, window.bucket_us));
       k * window.bucket_us < request.to_us && k * per_bucket < all; ++k) {
    const std::int64_t begin = k * per_bucket, end = std::min(begin + per_bucket, all);
    const Sum sum = over(static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
    window.add(k * window.bucket_us + window.bucket_us / 2, sum.least / bin_ms,
               static_cast<double>(sum.events) / (bin_ms * static_cast<double>(end - begin)), sum.most / bin_ms);
  }
  return window;
}

RateLevels::Busiest RateLevels::busiest(microseconds length) const {
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

SignalWindow exact_rate(std::span<const CameraTime> events, CameraTime first, const WindowRequest& request) {
  SignalWindow window;
  window.bucket_us = request.bucket_us(1);
  const std::int64_t begin = multiple_below(request.from_us, window.bucket_us);
  const std::int64_t end = multiple_below(request.to_us - 1, window.bucket_us) + 1;
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(end - begin));
  for (const CameraTime t : events) {
    const std::int64_t bucket = multiple_below(between(first, t).count(), window.bucket_us);
    if (bucket >= begin && bucket < end) ++counts[static_cast<std::size_t>(bucket - begin)];
  }
  const double bucket_ms = static_cast<double>(window.bucket_us) / us_per_ms;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double rate = static_cast<double>(counts[i]) / bucket_ms;
    window.add((begin + static_cast<std::int64_t>(i)) * window.bucket_us + window.bucket_us / 2, rate, rate, rate);
  }
  return window;
}

}  // namespace tactile::review
