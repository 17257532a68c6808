#include "tactile/events/repair.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/output_file.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/packet_writer.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/events/stream_time.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

/// One stream during the repair.
struct StreamRepair {
  RepairedStream result;
  StampMeter stamps{microseconds::max(), 0};
};

/// Copies packets from a reader to a writer.
class Repair {
 public:
  Repair(RecordingReader& recording, PacketWriter& writer) : recording_(recording), writer_(writer), checksums_(recording) {
    for (const Stream& stream : recording.streams()) streams_.emplace_back().result.stream = stream;
  }

  void keep(const PacketRecord& packet) {
    StreamRepair& stream = *std::find_if(streams_.begin(), streams_.end(),
                                         [&](const StreamRepair& s) { return s.result.stream.id == packet.stream_id; });
    const bool is_damaged = checksums_.used() && checksums_.check(packet, recording_.read_stored(packet)) == PacketCheck::damaged;
    damaged_ += is_damaged ? 1 : 0;
    if (!is_damaged && keep_of_type(packet, stream)) {
      ++stream.result.packets_kept;
    } else {
      ++stream.result.packets_lost;
      stream.result.bytes_lost += packet_header_size + packet.payload_size;
    }
  }

  RepairSummary summary() const {
    RepairSummary summary;
    for (const StreamRepair& stream : streams_) {
      RepairedStream result = stream.result;
      const StampHealth stamps = stream.stamps.health();
      result.elements_kept += stamps.elements;
      result.steps_back = stamps.steps_back_in_packets + stamps.steps_back_between_packets;
      summary.streams.push_back(std::move(result));
    }
    summary.packets_damaged = damaged_;
    summary.header_damaged = checksums_.header_damaged();
    summary.packets_rewritten = rewritten_;
    summary.problems = recording_.problems();
    summary.index = recording_.index();
    return summary;
  }

 private:
  bool keep_of_type(const PacketRecord& packet, StreamRepair& stream) {
    switch (stream.result.stream.type) {
      case StreamType::events: {
        const std::span<const Event> events = recording_.read_events(packet);
        return keep_elements(packet, stream, events, [&] {
          content_.grow(event_packet_head + events.size_bytes(), 0);
          write_event_packet_head(content_.data(), events.size());
          std::memcpy(content_.data() + event_packet_head, events.data(), events.size_bytes());
          return event_packet_head + events.size_bytes();
        });
      }
      case StreamType::imu: {
        const std::vector<ImuSample> samples = recording_.read_imu(packet);
        return keep_elements(packet, stream, std::span(samples), [&] { return encode_imu(samples, content_, 0); });
      }
      case StreamType::triggers: {
        const std::vector<Trigger> triggers = recording_.read_triggers(packet);
        return keep_elements(packet, stream, std::span(triggers), [&] { return encode_triggers(triggers, content_, 0); });
      }
      case StreamType::frames: {
        const std::optional<Frame> frame = recording_.read_frame(packet);
        if (!frame) return false;
        return keep_elements(packet, stream, std::span(&*frame, 1), [&] { return encode_frame(*frame, content_, 0); });
      }
      case StreamType::other:
        stream.result.elements_kept += static_cast<std::uint64_t>(std::max<std::int64_t>(packet.elements, 0));
        writer_.write(packet, recording_.read_stored(packet));
        return true;
    }
    return false;
  }

  /// Writes the packet as it is stored, unless the reader corrected it.
  template <class Element, class Encode>
  bool keep_elements(PacketRecord packet, StreamRepair& stream, std::span<const Element> sound, const Encode& encode) {
    if (sound.empty()) return false;
    packet.elements = static_cast<std::int64_t>(sound.size());
    const auto [first, last] = time_extent_of(sound);
    packet.first = first;
    packet.last = last;
    stream.stamps.begin_packet();
    for (const Element& element : sound) stream.stamps.add(element.t);
    if (!recording_.was_corrected(packet)) {
      writer_.write(packet, recording_.read_stored(packet));
    } else {
      ++rewritten_;
      const std::size_t size = encode();
      writer_.write_content(packet, content_, size);
    }
    return true;
  }

  RecordingReader& recording_;
  PacketWriter& writer_;
  PacketChecksums checksums_;
  std::vector<StreamRepair> streams_;
  std::uint64_t damaged_ = 0, rewritten_ = 0;
  PacketBuffer content_;
};

}  // namespace

std::uint64_t RepairSummary::packets_kept() const {
  return std::accumulate(streams.begin(), streams.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const RepairedStream& s) { return sum + s.packets_kept; });
}

std::uint64_t RepairSummary::packets_lost() const {
  return std::accumulate(streams.begin(), streams.end(), problems.undeclared_packets,
                         [](std::uint64_t sum, const RepairedStream& s) { return sum + s.packets_lost; });
}

std::uint64_t RepairSummary::bytes_lost() const {
  return std::accumulate(streams.begin(), streams.end(), problems.truncated_bytes + problems.skipped_bytes,
                         [](std::uint64_t sum, const RepairedStream& s) { return sum + s.bytes_lost; });
}

RepairSummary repair_recording(const fs::path& in, const fs::path& out, bool replace, unsigned threads,
                               const ProgressCallback& progress) {
  if (out.extension() != ".aedat4")
    throw Error(out.string() + ": a repaired recording is AEDAT4; expected a name that ends in .aedat4");
  RecordingReader recording(in, threads);
  if (recording.encoding() != RecordingEncoding::aedat4)
    throw Error(in.string() +
                ": is a Prophesee RAW file, which has no packets to repair; expected an AEDAT4 recording: 'tactile "
                "convert' makes one");
  check_target(out, in, replace);
  WholeFile whole(out, replace ? IfThere::replace : IfThere::refuse);
  PacketWriter writer(whole.path(), out.string(), recording.compression(), recording.streams());
  Repair repair(recording, writer);
  for (const PacketRecord& packet : recording.packets()) {
    report_progress(progress, packet.payload_offset, recording.file_size(), out.filename().string());
    repair.keep(packet);
  }
  writer.close();
  RepairSummary summary = repair.summary();
  if (summary.packets_kept() == 0) throw Error(in.string() + ": no whole packet to keep; expected a recording with data");
  whole.commit();
  summary.bytes_in = recording.file_size();
  summary.bytes_out = fs::file_size(out);
  return summary;
}

}  // namespace tactile::events
