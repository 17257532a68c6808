#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

/// What one stream has in one piece of a recording.
struct PieceStream {
  Stream stream;
  std::uint64_t elements = 0;
  std::optional<CameraTime> first, last;  ///< the earliest and the latest; nothing without elements, or of an unknown type
};

/// One piece as it was written.
struct WrittenPiece {
  std::vector<PieceStream> streams;   ///< in the order of the recording
  std::uint64_t packets_copied = 0;   ///< as they were stored
  std::uint64_t packets_encoded = 0;  ///< again: at a cut, or corrected by the reader
};

/// Divides an AEDAT4 recording at times into pieces. Piece i has the elements with `cuts[i - 1] <= t < cuts[i]`, the first all
/// earlier ones, the last all later ones, each at its own time and in the order of the file. So the pieces one after the other
/// have every element of the kept streams once. A packet that lies in one piece is copied as it is stored; one with a cut inside
/// is encoded again, in parts. A packet of an unknown type goes to the piece of the packet before it. Streams, ids, attributes
/// and compression stay. A packet that cannot be decoded is in no piece, and is counted in `recording.problems()`.
///
/// Reads the recording once. Memory follows the packet, and the data tables of the pieces.
/// @param kept    its streams that the pieces have
/// @param cuts    ascending, each once
/// @param pieces  `cuts.size() + 1` new files
/// @throws Error  if the recording is no AEDAT4, cannot be read, or a piece cannot be written
std::vector<WrittenPiece> cut_recording(RecordingReader& recording, std::span<const Stream> kept,
                                        std::span<const CameraTime> cuts, std::span<const std::filesystem::path> pieces,
                                        const ProgressCallback& progress = {});

/// How many elements each piece of one event stream would have, by the list of packets: only the packets with a cut inside are
/// read. Damaged events, which readers drop, may count here.
std::vector<std::uint64_t> events_of_pieces(RecordingReader& recording, std::int32_t stream_id, std::span<const CameraTime> cuts);

/// The index of the piece that holds `t`.
std::size_t piece_of(std::span<const CameraTime> cuts, CameraTime t);

}  // namespace tactile::events
