#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::bench {

/// The pixels and polarities of a recording, again and again, at a constant rate: each millisecond is five read-outs.
class RepeatedEvents {
 public:
  /// @param per_packet  events of each packet, > 0
  RepeatedEvents(const std::string& file, std::size_t per_packet, std::int64_t packet_ms, CameraTime begin)
      : per_packet_(per_packet), packet_ms_(packet_ms), begin_(begin) {
    const std::size_t wanted = std::max(per_packet, std::size_t{1} << 21);
    while (events_.size() < wanted) {
      const std::size_t before = events_.size();
      events::RecordingReader recording(file);
      events::for_all_events(recording, events::event_stream(recording).id, [&](std::span<const events::Event> events) {
        events_.insert(events_.end(), events.begin(), events.end());
      });
      if (events_.size() == before) throw Error(file + ": no events; expected some");
    }
  }

  /// The next packet, with its times. Valid until the next call.
  std::span<const events::Event> next() {
    if (next_ + per_packet_ > events_.size()) next_ = 0;
    const std::span packet = std::span(events_).subspan(next_, per_packet_);
    const auto readouts = static_cast<std::size_t>(5 * packet_ms_);
    for (std::size_t k = 0; k < packet.size(); ++k)
      packet[k].t = begin_ + microseconds{200 * static_cast<std::int64_t>(readouts * k / packet.size())};
    next_ += per_packet_;
    begin_ += std::chrono::milliseconds(packet_ms_);
    return packet;
  }

 private:
  std::size_t per_packet_;
  std::int64_t packet_ms_;
  CameraTime begin_;  ///< of the next packet
  std::vector<events::Event> events_;
  std::size_t next_ = 0;
};

}  // namespace tactile::bench
