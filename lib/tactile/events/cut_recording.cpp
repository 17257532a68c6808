#include "tactile/events/cut_recording.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <deque>

#include "tactile/core/error.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/packet_writer.hpp"
#include "tactile/events/stream_time.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

std::size_t encode(std::span<const Event> events, PacketBuffer& content) {
  content.grow(event_packet_head + events.size_bytes(), 0);
  write_event_packet_head(content.data(), events.size());
  std::memcpy(content.data() + event_packet_head, events.data(), events.size_bytes());
  return event_packet_head + events.size_bytes();
}
std::size_t encode(std::span<const ImuSample> samples, PacketBuffer& content) { return encode_imu(samples, content, 0); }
std::size_t encode(std::span<const Trigger> triggers, PacketBuffer& content) { return encode_triggers(triggers, content, 0); }
std::size_t encode(std::span<const Frame> frames, PacketBuffer& content) { return encode_frame(frames.front(), content, 0); }

/// The second reading: passes packets to the files of the pieces.
class Cutting {
 public:
  Cutting(RecordingReader& recording, std::span<const Stream> kept, std::span<const CameraTime> cuts,
          std::span<const fs::path> pieces)
      : recording_(recording), cuts_(cuts) {
    for (const fs::path& piece : pieces) {
      writers_.emplace_back(piece, piece.string(), recording.compression(), kept);
      WrittenPiece& written = written_.emplace_back();
      for (const Stream& stream : kept) written.streams.push_back({.stream = stream, .first = {}, .last = {}});
    }
  }

  void pass(const PacketRecord& packet) {
    const std::vector<PieceStream>& kept = written_.front().streams;
    if (std::none_of(kept.begin(), kept.end(), [&](const PieceStream& s) { return s.stream.id == packet.stream_id; })) return;
    switch (recording_.stream(packet.stream_id).type) {
      case StreamType::events:
        pass_elements(packet, std::span<const Event>(recording_.read_events(packet)));
        break;
      case StreamType::imu:
        pass_elements(packet, std::span<const ImuSample>(imu_ = recording_.read_imu(packet)));
        break;
      case StreamType::triggers:
        pass_elements(packet, std::span<const Trigger>(triggers_ = recording_.read_triggers(packet)));
        break;
      case StreamType::frames:
        frame_ = recording_.read_frame(packet);
        if (frame_) pass_elements(packet, std::span<const Frame>(&*frame_, 1));
        break;
      case StreamType::other:
        copy(packet, last_piece_);
        stream_of(last_piece_, packet.stream_id).elements +=
            static_cast<std::uint64_t>(std::max<std::int64_t>(packet.elements, 0));
        break;
    }
  }

  std::vector<WrittenPiece> finish() {
    for (PacketWriter& writer : writers_) writer.close();
    return std::move(written_);
  }

 private:
  template <class Element>
  void pass_elements(PacketRecord packet, std::span<const Element> elements) {
    if (elements.empty()) return;
    const TimeExtent extent = time_extent_of(elements);
    const std::size_t first = piece_of(cuts_, extent.first), last = piece_of(cuts_, extent.last);
    if (first == last && !recording_.was_corrected(packet)) {
      packet.elements = static_cast<std::int64_t>(elements.size());
      packet.first = extent.first;
      packet.last = extent.last;
      count(packet, first);
      copy(packet, first);
      return;
    }
    std::vector<Element> part;
    for (std::size_t piece = first; piece <= last; ++piece) {
      part.clear();
      std::copy_if(elements.begin(), elements.end(), std::back_inserter(part),
                   [&](const Element& element) { return piece_of(cuts_, element.t) == piece; });
      if (!part.empty()) write_part(packet, std::span<const Element>(part), piece);
    }
  }

  template <class Element>
  void write_part(PacketRecord packet, std::span<const Element> elements, std::size_t piece) {
    const TimeExtent extent = time_extent_of(elements);
    packet.elements = static_cast<std::int64_t>(elements.size());
    packet.first = extent.first;
    packet.last = extent.last;
    count(packet, piece);
    const std::size_t size = encode(elements, content_);
    writers_[piece].write_content(packet, content_, size);
    ++written_[piece].packets_encoded;
    last_piece_ = piece;
  }

  void copy(const PacketRecord& packet, std::size_t piece) {
    writers_[piece].write(packet, recording_.read_stored(packet));
    ++written_[piece].packets_copied;
    last_piece_ = piece;
  }

  void count(const PacketRecord& packet, std::size_t piece) {
    PieceStream& stream = stream_of(piece, packet.stream_id);
    stream.elements += static_cast<std::uint64_t>(packet.elements);
    stream.first = stream.first ? std::min(*stream.first, packet.first) : packet.first;
    stream.last = stream.last ? std::max(*stream.last, packet.last) : packet.last;
  }

  PieceStream& stream_of(std::size_t piece, std::int32_t id) {
    std::vector<PieceStream>& streams = written_[piece].streams;
    const auto found = std::find_if(streams.begin(), streams.end(), [id](const PieceStream& s) { return s.stream.id == id; });
    assert(found != streams.end() && "the reader lists packets of declared streams only");
    return *found;
  }

  RecordingReader& recording_;
  std::span<const CameraTime> cuts_;
  std::deque<PacketWriter> writers_;
  std::vector<WrittenPiece> written_;
  std::size_t last_piece_ = 0;
  PacketBuffer content_;
  std::vector<ImuSample> imu_;
  std::vector<Trigger> triggers_;
  std::optional<Frame> frame_;
};

}  // namespace

std::size_t piece_of(std::span<const CameraTime> cuts, CameraTime t) {
  return static_cast<std::size_t>(std::upper_bound(cuts.begin(), cuts.end(), t) - cuts.begin());
}

std::vector<WrittenPiece> cut_recording(RecordingReader& recording, std::span<const Stream> kept,
                                        std::span<const CameraTime> cuts, std::span<const fs::path> pieces,
                                        const ProgressCallback& progress) {
  assert(pieces.size() == cuts.size() + 1 && "n cuts make n + 1 pieces");
  if (recording.encoding() != RecordingEncoding::aedat4)
    throw Error(recording.file().string() + ": is a Prophesee RAW file; expected AEDAT4, which 'tactile convert' makes of it");
  Cutting cutting(recording, kept, cuts, pieces);
  for (const PacketRecord& packet : recording.packets()) {
    report_progress(progress, packet.payload_offset, recording.file_size(), recording.file().filename().string());
    cutting.pass(packet);
  }
  return cutting.finish();
}

std::vector<std::uint64_t> events_of_pieces(RecordingReader& recording, std::int32_t stream_id,
                                            std::span<const CameraTime> cuts) {
  std::vector<std::uint64_t> counts(cuts.size() + 1);
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id || packet.elements <= 0) continue;
    const std::size_t first = piece_of(cuts, packet.first), last = piece_of(cuts, packet.last);
    if (first == last) {
      counts[first] += static_cast<std::uint64_t>(packet.elements);
      continue;
    }
    for (const Event& event : recording.read_events(packet)) ++counts[piece_of(cuts, event.t)];
  }
  return counts;
}

}  // namespace tactile::events
