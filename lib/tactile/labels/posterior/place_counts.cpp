#include "tactile/labels/posterior/place_counts.hpp"

#include <algorithm>
#include <numeric>

namespace tactile::labels {
namespace {

std::size_t part_of(int position, int size, std::size_t parts) {
  return std::min(parts - 1, static_cast<std::size_t>(position) * parts / static_cast<std::size_t>(std::max(size, 1)));
}

}  // namespace

PlaceCounts place_counts(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate,
                         std::span<const alignment::CameraSpan> gaps, microseconds longest) {
  const events::SensorSize size = recording.stream(stream).size.value_or(events::SensorSize{});
  const auto joined = static_cast<std::size_t>(std::max<std::int64_t>(1, longest / rate.bin));
  const std::size_t bins = (rate.counts.size() + joined - 1) / joined;
  PlaceCounts result{.begin = rate.begin, .bin = rate.bin * static_cast<std::int64_t>(joined)};
  result.counts.assign(bins * PlaceCounts::places, 0);
  std::vector<std::uint64_t> events_of(bins + 1, 0);
  for (std::size_t i = 0; i < rate.counts.size(); ++i) events_of[i / joined + 1] += rate.counts[i];
  std::partial_sum(events_of.begin(), events_of.end(), events_of.begin());
  result.first_sign = events_of;
  result.signs.resize(events_of.back());
  for_counted_events(recording, stream, rate, [&](const events::Event& event, std::size_t fine) {
    const std::size_t bin = fine / joined;
    const std::size_t place = part_of(event.y, size.height, PlaceCounts::down) * PlaceCounts::across +
                              part_of(event.x, size.width, PlaceCounts::across);
    std::uint16_t& count = result.counts[bin * PlaceCounts::places + place];
    if (count < 65535) ++count;
    const std::size_t cell = part_of(event.y, size.height, PlaceCounts::cells_down) * PlaceCounts::cells_across +
                             part_of(event.x, size.width, PlaceCounts::cells_across);
    if (events_of[bin] < result.signs.size())
      result.signs[events_of[bin]++] = {static_cast<std::uint16_t>(cell), static_cast<std::int8_t>(event.on ? 1 : -1)};
  });
  result.recorded.assign(bins, true);
  for (std::size_t b = 0; b < bins; ++b) {
    const CameraTime begin = result.begin_of(b), end = result.begin_of(b + 1);
    result.recorded[b] = std::none_of(gaps.begin(), gaps.end(),
                                      [&](const alignment::CameraSpan& gap) { return gap.begin < end && begin < gap.end; });
  }
  return result;
}

}  // namespace tactile::labels
