#include "tactile/labels/brightening.hpp"

#include <cmath>

#include "tactile/labels/stretches.hpp"

namespace tactile::labels {

double correlation_of(const Brightening& a, const Brightening& b) {
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += static_cast<double>(a[i]) * a[i];
    bb += static_cast<double>(b[i]) * b[i];
    ab += static_cast<double>(a[i]) * b[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
}

void add(Brightening& sum, const Brightening& more) {
  for (std::size_t cell = 0; cell < sum.size(); ++cell) sum[cell] += more[cell];
}

std::vector<Brightening> brightenings_of(events::RecordingReader& recording, std::int32_t stream_id,
                                         const alignment::EventRate& rate, std::span<const alignment::Burst> bursts) {
  const ImageCells cells(*recording.stream(stream_id).size);
  std::vector<Brightening> found(bursts.size(), Brightening(cells.count()));
  std::vector<Stretch> spans;
  for (const alignment::Burst& burst : bursts) spans.push_back({burst.begin, burst.end});
  Stretches near(spans);
  alignment::for_counted_events(recording, stream_id, rate, [&](const events::Event& event, std::size_t bin) {
    const Stretch candidates = near.around(bin);
    for (std::size_t i = candidates.begin; i < candidates.end; ++i) {
      if (spans[i].holds(bin)) found[i][cells.at(event)] += event.on != 0 ? 1 : -1;
    }
  });
  return found;
}

}  // namespace tactile::labels
