#include <fcntl.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/repair.hpp"

/// Whatever the bytes, the reader either reads them or says in an Error why it cannot.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const int file = memfd_create("recording", MFD_CLOEXEC);
  if (file < 0 || write(file, data, size) != static_cast<ssize_t>(size)) return 0;
  try {
    const std::string path = "/proc/self/fd/" + std::to_string(file);
    RecordingReader recording(path, size % 4 == 0 ? 2 : 1);
    for (const PacketRecord& packet : recording.packets()) {
      switch (recording.stream(packet.stream_id).type) {
        case StreamType::events:
          recording.read_events(packet);
          break;
        case StreamType::imu:
          recording.read_imu(packet);
          break;
        case StreamType::triggers:
          recording.read_triggers(packet);
          break;
        case StreamType::frames:
          recording.read_frame(packet);
          break;
        case StreamType::other:
          break;
      }
    }
    if (size % 8 == 0) {
      const std::filesystem::path out = std::filesystem::temp_directory_path() / fmt::format("repaired_{}.aedat4", getpid());
      repair_recording(path, out, true);
      std::filesystem::remove(out);
    }
  } catch (const Error&) {
  }
  close(file);
  return 0;
}
