#pragma once

#include <vector>

#include "tactile/events/recording_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// The packets that a recording has.
struct PacketList {
  std::vector<PacketRecord> packets;  ///< in file order, of declared streams; from a table with elements and times
  PacketIndex index = PacketIndex::scan;
  RecordingProblems problems;  ///< those that show without reading the packets' contents
};

/// Finds the packets from header to header. A data table is used only if it agrees with them. Where the bytes cannot be a header,
/// the search resumes
///
///   1. at the packet that the data table has there, or at its next one, if there is a table and that place holds a packet,
///   2. otherwise at the next place that looks like a packet: a declared stream, a size that fits, a valid start of the contents,
///      and then the end of the data, another such place, or contents that prove complete.
///
/// A wrong size in a header is corrected from the table or from the place of the next packet. The cost grows linearly with the
/// file's size, whatever its bytes.
/// @throws Error  if the file cannot be read
PacketList find_packets(const RecordingFile& file, const RecordingStart& start);

}  // namespace tactile::events
