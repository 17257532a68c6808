#include <filesystem>

#include "bytes_as_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/repair.hpp"

/// For any input, the reader and the repair read it, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  static const test::TemporaryFolder folder;
  const test::BytesAsFile file(data, size);
  try {
    events::RecordingReader recording(file.path(), size % 4 == 0 ? 2 : 1);
    for (const events::PacketRecord& packet : recording.packets()) {
      switch (recording.stream(packet.stream_id).type) {
        case events::StreamType::events:
          recording.read_events(packet);
          break;
        case events::StreamType::imu:
          recording.read_imu(packet);
          break;
        case events::StreamType::triggers:
          recording.read_triggers(packet);
          break;
        case events::StreamType::frames:
          recording.read_frame(packet);
          break;
        case events::StreamType::other:
          break;
      }
    }
    if (size % 8 == 0) {
      events::repair_recording(file.path(), folder / "repaired.aedat4", true);
      std::filesystem::remove(folder / "repaired.aedat4");
    }
  } catch (const Error&) {
  }
  return 0;
}
