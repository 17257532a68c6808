#include "tactile/labels/recording_span.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::labels {

RecordingSpan span_of_events(const RunFolder& run) {
  events::RecordingReader recording(run.events());
  const std::int32_t id = events::event_stream(recording).id;
  RecordingSpan span{CameraTime::max(), CameraTime::min()};
  // The table's times are only a hint. The events of the outermost non-empty packets count.
  std::vector<events::PacketRecord> packets;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.stream_id == id && packet.elements > 0) packets.push_back(packet);
  }
  const auto widen = [&](const events::PacketRecord& packet) {
    const std::span<events::Event> events = recording.read_events(packet);
    for (const events::Event& event : events) span = {std::min(span.first, event.t), std::max(span.last, event.t)};
    return !events.empty();
  };
  std::stable_sort(packets.begin(), packets.end(),
                   [](const events::PacketRecord& a, const events::PacketRecord& b) { return a.first < b.first; });
  if (std::none_of(packets.begin(), packets.end(), widen))
    throw Error(run.events().string() + ": has no event; expected a recording with events");
  std::stable_sort(packets.begin(), packets.end(),
                   [](const events::PacketRecord& a, const events::PacketRecord& b) { return a.last > b.last; });
  static_cast<void>(std::any_of(packets.begin(), packets.end(), widen));
  return span;
}

}  // namespace tactile::labels
