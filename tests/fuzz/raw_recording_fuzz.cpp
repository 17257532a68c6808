#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"

/// For any input, a RAW file is read whose pieces hold what their records say, or there is an Error. Without a header the input
/// is read as words of EVT2 or EVT3.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  using test::abort_unless;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (!bytes.starts_with("% ")) bytes.insert(0, size % 2 == 0 ? "% evt 3.0\n% geometry 640x480\n% end\n" : "% evt 2.0\n% end\n");
  const test::BytesAsFile file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  try {
    events::RecordingReader recording(file.path());
    for (const events::PacketRecord& packet : recording.packets()) {
      std::int64_t elements = 0;
      if (recording.stream(packet.stream_id).type == events::StreamType::triggers) {
        elements = static_cast<std::int64_t>(recording.read_triggers(packet).size());
      } else {
        const auto size_of_sensor = recording.stream(packet.stream_id).size.value_or(events::SensorSize{2048, 2048});
        for (const events::Event& event : recording.read_events(packet)) {
          abort_unless(event.x >= 0 && event.x < size_of_sensor.width && event.y >= 0 && event.y < size_of_sensor.height);
          abort_unless(event.t >= packet.first && event.t <= packet.last && event.on <= 1);
          ++elements;
        }
      }
      abort_unless(elements == packet.elements && elements > 0);
    }
  } catch (const Error&) {
  }
  return 0;
}
