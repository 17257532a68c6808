#include "tactile/pictures/event_curve.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>

namespace tactile::pictures {

EventCurve::EventCurve(CameraTime begin, microseconds bin, std::size_t most_bins)
    : begin_(begin), bin_(bin), most_bins_(most_bins) {
  assert(bin > microseconds{0} && most_bins > 0 && most_bins % 2 == 0);
}

void EventCurve::add(std::span<const events::Event> events) {
  // Events of one read-out share their time, and mostly their bin with the ones before.
  for (std::size_t i = 0; i < events.size();) {
    const CameraTime t = events[i].t;
    std::size_t past_end = i + 1;
    while (past_end < events.size() && events[past_end].t == t) ++past_end;
    if (t >= begin_) bin_of(t) += past_end - i;
    i = past_end;
  }
}

std::uint64_t& EventCurve::bin_of(CameraTime t) {
  const microseconds since = between(begin_, t);
  while (static_cast<std::uint64_t>(since / bin_) >= most_bins_) {
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const std::uint64_t count = counts_[i];
      if (i % 2 == 0)
        counts_[i / 2] = count;
      else
        counts_[i / 2] += count;
    }
    counts_.resize((counts_.size() + 1) / 2);
    bin_ *= 2;
  }
  const auto index = static_cast<std::size_t>(since / bin_);
  if (index >= counts_.size()) counts_.resize(index + 1);
  return counts_[index];
}

double EventCurve::most_per_ms(CameraTime from, CameraTime to) const {
  if (to <= from || to <= begin_) return 0;
  const auto index_of = [&](CameraTime t) {
    return std::min(counts_.size(), static_cast<std::size_t>(std::max(microseconds{0}, between(begin_, t)) / bin_));
  };
  // The bin that holds the last microsecond before `to` is the last one.
  const std::size_t first = index_of(from), past_end = std::min(counts_.size(), index_of(before(to, microseconds{1})) + 1);
  std::uint64_t most = 0;
  for (std::size_t i = first; i < past_end; ++i) most = std::max(most, counts_[i]);
  return 1000 * static_cast<double>(most) / static_cast<double>(bin_.count());
}

}  // namespace tactile::pictures
