#include "tactile/labels/visible_onset.hpp"

#include <algorithm>
#include <numeric>

namespace tactile::labels {

std::optional<CameraTime> visible_onset(const alignment::EventRate& rate, const alignment::QuietRate& quiet,
                                        const alignment::UncertainTime& onset, CameraTime end) {
  constexpr double least_events = 5, times_quiet = 2;
  const auto width = std::max<std::ptrdiff_t>(1, 2ms / rate.bin);
  const auto bin_of = [&](CameraTime t) {
    return std::clamp<std::ptrdiff_t>(between(rate.begin, t) / rate.bin, 0, std::ssize(rate.counts));
  };
  const double limit = times_quiet * quiet.mean * static_cast<double>(width);
  for (std::ptrdiff_t bin = bin_of(onset.low); bin + width <= bin_of(end); ++bin) {
    const auto first = rate.counts.begin() + bin;
    const double events = std::accumulate(first, first + width, 0.0);
    if (*first > 0 && events > limit && events >= least_events) return rate.begin_of(static_cast<std::size_t>(bin));
  }
  return std::nullopt;
}

}  // namespace tactile::labels
