#include "tactile/windows/event_counts.hpp"

#include <algorithm>

namespace tactile::windows {

std::vector<std::uint64_t> event_counts(const Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                        microseconds history, const events::MaskPixels& mask) {
  std::vector<events::Event> events = dataset.events(run);
  const events::PixelMask masked(dataset.sensor(), mask);
  if (!masked.empty()) std::erase_if(events, [&](const events::Event& event) { return masked.covers(event); });
  const auto place_of = [&events](CameraTime t) {
    return std::lower_bound(events.begin(), events.end(), t,
                            [](const events::Event& event, CameraTime time) { return event.t < time; });
  };
  std::vector<std::uint64_t> counts;
  for (const std::uint32_t sample : samples) {
    const CameraTime t = dataset.samples()[sample].t;
    counts.push_back(static_cast<std::uint64_t>(place_of(t) - place_of(before(t, history))));
  }
  return counts;
}

}  // namespace tactile::windows
