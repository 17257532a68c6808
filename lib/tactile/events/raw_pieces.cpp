#include "tactile/events/raw_pieces.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "tactile/events/evt2.hpp"
#include "tactile/events/evt3.hpp"
#include "tactile/events/recording_file.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/events/stream_time.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t piece_bytes = std::size_t{64} << 10;
constexpr SensorSize largest_image{2048, 2048};

template <class Decoder>
class DecodedPieces final : public RawPieces {
 public:
  DecodedPieces(const RecordingFile& file, const RawHeader& header)
      : file_(&file), begin_(header.data_begin), sensor_(header.size.value_or(largest_image)), decoder_(sensor_) {}

  std::vector<PacketRecord> find(RecordingProblems& problems) override {
    std::vector<PacketRecord> records;
    const std::uint64_t size = (file_->size() - begin_) / Decoder::word_bytes * Decoder::word_bytes;
    for (std::uint64_t at = 0; at < size; at += piece_bytes) {
      states_.push_back(decoder_.state());
      PacketRecord piece{.stream_id = event_stream_id,
                         .payload_offset = begin_ + at,
                         .payload_size = static_cast<std::uint32_t>(std::min<std::uint64_t>(piece_bytes, size - at))};
      decode_next(piece);
      if (!events_.empty()) {
        const auto [first, last] = time_extent_of(std::span<const Event>(events_));
        piece.elements = static_cast<std::int64_t>(events_.size());
        piece.first = first;
        piece.last = last;
        records.push_back(piece);
      }
      if (triggers_.empty()) continue;
      const auto [first, last] = time_extent_of(std::span<const Evt3Trigger>(triggers_));
      records.push_back({.stream_id = trigger_stream_id,
                         .payload_offset = piece.payload_offset,
                         .payload_size = piece.payload_size,
                         .elements = static_cast<std::int64_t>(triggers_.size()),
                         .first = first,
                         .last = last});
    }
    problems.truncated_bytes = file_->size() - begin_ - size;
    problems.skipped_bytes = Decoder::word_bytes * decoder_.problems().unknown_words;
    problems.out_of_range_events = decoder_.problems().outside;
    return records;
  }

  std::span<Event> events(const PacketRecord& record) override {
    decode(record);
    return events_;
  }

  std::vector<Trigger> triggers(const PacketRecord& record) override {
    decode(record);
    std::vector<Trigger> triggers;
    std::transform(triggers_.begin(), triggers_.end(), std::back_inserter(triggers), trigger_of);
    return triggers;
  }

 private:
  /// Valid until the next call.
  std::span<const std::byte> bytes_of(const PacketRecord& piece) {
    bytes_.resize(piece_bytes);
    const std::span<std::byte> bytes = std::span(bytes_).first(piece.payload_size);
    file_->read(piece.payload_offset, bytes);
    return bytes;
  }

  void decode(const PacketRecord& piece) {
    decoder_.resume(states_.at(static_cast<std::size_t>((piece.payload_offset - begin_) / piece_bytes)));
    decode_next(piece);
  }

  void decode_next(const PacketRecord& piece) {
    events_.clear();
    triggers_.clear();
    decoder_.decode(bytes_of(piece), events_, triggers_);
  }

  const RecordingFile* file_;
  std::uint64_t begin_;  ///< of the words [B]
  SensorSize sensor_;
  Decoder decoder_;
  std::vector<typename Decoder::State> states_;  ///< at the start of each piece
  std::vector<std::byte> bytes_;
  std::vector<Event> events_;
  std::vector<Evt3Trigger> triggers_;
};

}  // namespace

std::unique_ptr<RawPieces> open_raw_pieces(const RecordingFile& file, const RawHeader& header) {
  if (header.encoding == RecordingEncoding::evt2) return std::make_unique<DecodedPieces<Evt2Decoder>>(file, header);
  return std::make_unique<DecodedPieces<Evt3Decoder>>(file, header);
}

std::vector<Stream> raw_streams(const RawHeader& header) {
  Stream events = event_stream_declaration(header.size.value_or(largest_image), header.camera);
  events.id = RawPieces::event_stream_id;
  events.size = header.size;
  Stream triggers;
  triggers.id = RawPieces::trigger_stream_id;
  triggers.type = StreamType::triggers;
  triggers.type_identifier = identifier_of(StreamType::triggers);
  triggers.source = header.camera;
  return {std::move(events), completed(std::move(triggers))};
}

}  // namespace tactile::events
