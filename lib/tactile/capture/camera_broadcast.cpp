#include "tactile/capture/camera_broadcast.hpp"

#include <fmt/core.h>

#include <span>

#include "tactile/core/error.hpp"

namespace tactile::capture {
namespace {

/// Cuts before an element that is `span` or more after the packet's first one, or earlier than the previous one, and after the
/// largest number of elements.
template <class Element, class Use>
void cut(std::span<const Element> elements, microseconds span, std::size_t most, const Use& use) {
  while (!elements.empty()) {
    std::size_t count = 1;
    while (count < elements.size() && count < most && elements[count].t >= elements[count - 1].t &&
           between(elements.front().t, elements[count].t) < span) {
      ++count;
    }
    use(elements.first(count));
    elements = elements.subspan(count);
  }
}

}  // namespace

CameraBroadcast::CameraBroadcast(CameraBroadcastOptions options) : options_(options) {
  if (options_.packet_span <= microseconds{0}) throw Error("the span of a packet is not positive; expected at least 1 us");
  constexpr std::size_t most = 1'000'000;
  if (options_.packet_events < 1 || options_.packet_events > most) {
    throw Error(fmt::format("{} events per packet; expected 1 to {}", options_.packet_events, most));
  }
}

void CameraBroadcast::send(const CameraPacket& packet) {
  const auto [begin, end] = servers_.equal_range(packet.stream_id);
  if (begin == end) return;
  const auto to_all = [&, first = begin, last = end](const auto& elements) {
    for (auto at = first; at != last; ++at) at->second->send(elements);
    ++counts_.packets;
  };
  cut(std::span<const events::Event>(packet.events), options_.packet_span, options_.packet_events, to_all);
  cut(std::span<const events::ImuSample>(packet.imu), options_.packet_span, options_.packet_events, to_all);
  cut(std::span<const events::Trigger>(packet.triggers), options_.packet_span, options_.packet_events, to_all);
  if (packet.frame) to_all(*packet.frame);
  counts_.events += packet.events.size();
  counts_.imu_samples += packet.imu.size();
  counts_.triggers += packet.triggers.size();
  counts_.frames += packet.frame ? 1 : 0;
}

}  // namespace tactile::capture
