#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::events {

enum class StreamType : std::uint8_t { events, frames, imu, triggers, other };
enum class Compression : std::uint8_t { none = 0, lz4 = 1, lz4_high = 2, zstd = 3, zstd_high = 4 };

std::string_view name_of(StreamType type);             ///< "events", "frames", "imu", "triggers", "other"
std::string_view name_of(Compression compression);     ///< "none", "lz4", "lz4-high", "zstd", "zstd-high"
Compression compression_named(std::string_view name);  ///< @throws Error if it is none of the five

/// One stream as a recording declares it.
struct Stream {
  std::int32_t id = 0;
  StreamType type = StreamType::other;
  std::string type_identifier;                            ///< "EVTS", "FRME", "IMUS", "TRIG" or another four letters
  std::string source;                                     ///< camera, "DVXplorer_DXA00000"; may be empty
  std::string name;                                       ///< originalOutputName, "events"
  std::optional<SensorSize> size;                         ///< of events and frames
  std::vector<std::pair<std::string, std::string>> info;  ///< every further attribute of its info node, as text
};

/// The stream, with the name of its type and with `source` if it lacks them: a recording must declare both, but some programs do
/// not.
Stream completed(Stream stream, std::string_view source = "unknown");

/// The one event stream, or the one that `choice` names by id or source. `where` names the streams in an error.
/// @throws Error  with a list of the event streams, if none or more than one matches
const Stream& event_stream(std::span<const Stream> streams, std::string_view where, std::string_view choice = {});

}  // namespace tactile::events
