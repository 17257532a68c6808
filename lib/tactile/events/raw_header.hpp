#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/events/event.hpp"

namespace tactile::events {

class RecordingFile;

/// The formats of recordings that `RecordingReader` reads.
enum class RecordingEncoding : std::uint8_t { aedat4, evt2, evt3 };

std::string_view name_of(RecordingEncoding encoding);  ///< "AEDAT4", "EVT2", "EVT3"

/// The header of a Prophesee RAW file: lines of text that begin with "% ", as "% key value", up to "% end" or the first byte of
/// another kind.
struct RawHeader {
  RecordingEncoding encoding = RecordingEncoding::evt3;
  std::optional<SensorSize> size;  ///< by `geometry`, by `format`, or by the camera's generation
  std::string camera;              ///< "Prophesee_00000307": integrator and serial number
  std::uint64_t data_begin = 0;    ///< [B]
};

/// Whether a file with this start is RAW: it begins with a line of such a header.
bool is_raw(std::string_view start);

/// @throws Error  if the header does not name EVT2 or EVT3, or is longer than 64 KiB
RawHeader read_raw_header(const RecordingFile& file);

}  // namespace tactile::events
