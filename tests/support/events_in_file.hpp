#pragma once

#include <filesystem>
#include <vector>

#include "tactile/events/recording_reader.hpp"

namespace tactile::test {

/// All events of a recording, in the order of its packets.
inline std::vector<events::Event> events_in_file(const std::filesystem::path& file) {
  events::RecordingReader recording(file);
  std::vector<events::Event> all;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type != events::StreamType::events) continue;
    const auto events = recording.read_events(packet);
    all.insert(all.end(), events.begin(), events.end());
  }
  return all;
}

}  // namespace tactile::test
