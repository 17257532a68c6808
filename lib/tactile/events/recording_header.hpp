#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/stream.hpp"

namespace tactile::events {

/// The header of a recording, after the magic line: a size-prefixed IOHE buffer.
struct RecordingHeader {
  Compression compression = Compression::none;
  std::int64_t table_position = -1;  ///< [B] from the start of the file; negative: none
  std::vector<Stream> streams;

  const Stream* declared(std::int32_t id) const;  ///< the stream with this id; nullptr if there is none
};

inline constexpr std::size_t packet_header_size = 8;  ///< before each packet: int32 stream id, uint32 size of the contents [B]
inline constexpr std::string_view magic_line = "#!AER-DAT4.0\r\n";

/// @param bytes  the header with its size prefix, at an address aligned to 8
/// @param where  the name of the recording in an error
/// @throws Error  if it does not decode, or declares no stream
RecordingHeader read_header(std::span<const std::byte> bytes, std::string_view where);

struct HeaderImage {
  std::string bytes;               ///< the header with its size prefix
  std::size_t table_position = 0;  ///< offset of the int64 position, which is written later [B]
};

/// The header as the vendor's software writes it: position -1, streams in order of id.
HeaderImage header_image(Compression compression, std::span<const Stream> streams);

/// @throws Error  that begins with `where`, if the stream lacks what the vendor's reader requires: one of the four types, an id
/// of 0 or more, a name, a source, and for events and frames a size
void check_readable_by_vendor(const Stream& stream, std::string_view where);

/// The type that a packet's four letters name.
StreamType type_identified(std::string_view identifier);
std::string_view identifier_of(StreamType type);  ///< empty for `other`

}  // namespace tactile::events
