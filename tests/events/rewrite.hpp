#pragma once

#include <filesystem>
#include <vector>

#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

/// Writes everything that `recording` holds to a new file.
inline void rewrite(events::RecordingReader& recording, const std::filesystem::path& file,
                    events::RecordingWriterOptions options) {
  events::RecordingWriter writer(file, {recording.streams().begin(), recording.streams().end()}, options);
  for (const events::PacketRecord& packet : recording.packets()) {
    switch (recording.stream(packet.stream_id).type) {
      case events::StreamType::events:
        writer.write_events(packet.stream_id, recording.read_events(packet));
        break;
      case events::StreamType::imu:
        writer.write_imu(packet.stream_id, recording.read_imu(packet));
        break;
      case events::StreamType::triggers:
        writer.write_triggers(packet.stream_id, recording.read_triggers(packet));
        break;
      case events::StreamType::frames:
        if (const auto frame = recording.read_frame(packet)) writer.write_frame(packet.stream_id, *frame);
        break;
      case events::StreamType::other:
        break;
    }
  }
  writer.close();
}

}  // namespace tactile::test
