#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/raw_header.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// The events and triggers of a Prophesee RAW file. The file has no packets: it is divided into pieces of 64 KiB, which are read
/// as packets are. A piece is decoded from the state that the decoder had at its start. Memory follows the piece, and the list of
/// pieces.
class RawPieces {
 public:
  static constexpr std::int32_t event_stream_id = 0, trigger_stream_id = 1;

  virtual ~RawPieces() = default;

  /// Reads the file once. @return  a record for each piece with events, and for each with triggers
  virtual std::vector<PacketRecord> find(RecordingProblems& problems) = 0;

  /// The events of a record, valid until the next call. @throws Error  if the file cannot be read
  virtual std::span<Event> events(const PacketRecord& record) = 0;
  virtual std::vector<Trigger> triggers(const PacketRecord& record) = 0;
};

/// @param file  must outlive the result
std::unique_ptr<RawPieces> open_raw_pieces(const RecordingFile& file, const RawHeader& header);

/// The streams that such a file may have: events, and triggers.
std::vector<Stream> raw_streams(const RawHeader& header);

}  // namespace tactile::events
