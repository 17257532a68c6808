// Writes a long recording of many events: those of a short one, again and again, at a constant rate.
//
//   long_recording RECORDING MILLION_EVENTS_PER_S SECONDS FILE
//
// The file is compressed with LZ4, by two threads.

#include <fmt/core.h>

#include <cstddef>
#include <exception>
#include <string>

#include "repeated_events.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

int main(int argc, char** argv) {
  using namespace tactile;
  try {
    if (argc != 5) throw Error("long_recording: expected RECORDING MILLION_EVENTS_PER_S SECONDS FILE");
    events::RecordingReader recording(argv[1]);
    const events::Stream stream = events::event_stream_declaration(
        events::event_stream(recording).size.value_or(events::SensorSize{640, 480}), "DVXplorer_BENCH000");
    const auto per_ms = static_cast<std::size_t>(1000 * std::stod(argv[2]));
    if (per_ms < 1) throw Error("long_recording: expected at least 0.001 million events/s");
    bench::RepeatedEvents repeated(argv[1], per_ms, 1, camera_time(1'700'000'000'000'000));
    events::RecordingWriter writer(argv[4], {stream}, {.threads = 2});
    for (int ms = 0; ms < 1000 * std::stoi(argv[3]); ++ms) writer.write_events(stream.id, repeated.next());
    writer.close();
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
