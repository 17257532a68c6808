#include "tactile/events/recording_index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_probe.hpp"

namespace tactile::events {
namespace {

constexpr std::uint64_t zero_sector = 512;  // this many zeros in a row are lost bytes, not packets without contents [B]

/// The packets from the first on, as found by their headers.
struct FoundPackets {
  std::vector<PacketRecord> packets;  ///< with contents, declared or not
  std::uint64_t end = 0;              ///< of the last one [B]
  std::uint64_t empty = 0;            ///< packets without contents
  std::uint64_t skipped = 0;          ///< between packets [B]
  std::uint64_t resized = 0;          ///< packets whose own header has another size
  bool at_table = false;              ///< they end before a data table

  bool damaged() const { return skipped > 0 || resized > 0; }
};

class PacketFinder {
 public:
  PacketFinder(const RecordingFile& file, const RecordingStart& start)
      : header_(start.header), data_begin_(start.data_begin), size_(file.size()), probe_(file, start) {}

  PacketList find();

 private:
  std::string disagreement(const std::vector<PacketRecord>& entries, const FoundPackets& found_packets) const;
  std::vector<PacketRecord> hints_from(std::vector<PacketRecord> entries);

  FoundPackets find_packets(std::uint64_t end, const std::vector<PacketRecord>* table = nullptr);
  std::optional<std::uint64_t> resume(FoundPackets& found_packets, std::uint64_t at, std::uint64_t end,
                                      const std::vector<PacketRecord>& hints);
  std::optional<std::uint64_t> resume_by_table(FoundPackets& found_packets, std::uint64_t at, std::uint64_t end,
                                               const std::vector<PacketRecord>& hints);

  void count_missing(const std::vector<PacketRecord>& entries, const FoundPackets& found_packets);
  void take(FoundPackets found_packets);
  void take_table(const std::vector<PacketRecord>& entries);

  const RecordingHeader& header_;
  std::uint64_t data_begin_, size_;
  PacketProbe probe_;
  PacketList list_;
};

PacketList PacketFinder::find() {
  std::vector<PacketRecord> entries;
  std::string& why = list_.problems.table;
  const std::int64_t position = header_.table_position;
  const bool has_position = position >= 0 || position < -2;  // -1: not closed, -2: jAER's mark for the same
  std::optional<std::uint64_t> table_at;
  std::optional<FoundPackets> found_packets;
  if (has_position) {
    const auto announced = static_cast<std::uint64_t>(position);
    if (position < 0 || announced < data_begin_ || announced >= size_) {
      why = fmt::format("its position {} lies outside the packets' part of the file, {} to {}", position, data_begin_, size_);
    } else {
      why = probe_.read_table(announced, entries);
      if (why.empty()) table_at = announced;
    }
  }
  probe_.release_memory();  // the table may be as large as all entries
  if (!table_at) {
    found_packets = find_packets(size_);
    if (!found_packets->at_table) {
      list_.problems.truncated_bytes = size_ - found_packets->end;
    } else if (!has_position) {
      why = probe_.read_table(found_packets->end, entries);
      if (why.empty()) table_at = found_packets->end;
    }
  }
  if (table_at && (!found_packets || found_packets->damaged())) {
    found_packets = find_packets(*table_at, &entries);
    found_packets->skipped += *table_at - found_packets->end;
  }
  if (table_at) {
    why = found_packets->damaged() ? "packets before it are damaged" : disagreement(entries, *found_packets);
    if (!why.empty()) count_missing(entries, *found_packets);
  }
  take(std::move(*found_packets));
  if (table_at && why.empty()) {
    take_table(entries);
    list_.problems.header_not_patched = !has_position;
  }
  return std::move(list_);
}

/// The table's entries as hints where packets are, in ascending order; none if they are not ascending. One known writer gives the
/// place of a packet's header instead of its contents; the sound headers show which.
std::vector<PacketRecord> PacketFinder::hints_from(std::vector<PacketRecord> entries) {
  std::erase_if(entries, [](const PacketRecord& entry) { return entry.payload_size == 0; });
  const auto agree = [&](std::uint64_t back) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(entries.size(), 64); ++i) {
      const PacketRecord& entry = entries[i];
      if (entry.payload_offset < data_begin_ + back) continue;
      const auto header =
          entry.payload_offset - back < size_ ? probe_.header_at(entry.payload_offset - back, size_) : std::nullopt;
      count += header && header->stream_id == entry.stream_id && header->payload_size == entry.payload_size ? 1 : 0;
    }
    return count;
  };
  if (agree(packet_header_size) == 0 && agree(0) > 0) {
    for (PacketRecord& entry : entries) entry.payload_offset += packet_header_size;
  }
  const bool ascending = std::is_sorted(entries.begin(), entries.end(), [](const PacketRecord& a, const PacketRecord& b) {
    return a.payload_offset < b.payload_offset;
  });
  if (!ascending) entries.clear();
  return entries;
}

/// Walks from header to header up to `end` or a data table. Where there is damage, it also uses the entries of `table`.
FoundPackets PacketFinder::find_packets(std::uint64_t end, const std::vector<PacketRecord>* table) {
  FoundPackets found_packets;
  std::optional<std::vector<PacketRecord>> hints;  // made when first needed, because they take memory
  if (table != nullptr) found_packets.packets.reserve(table->size());
  std::uint64_t at = data_begin_;
  std::uint64_t empty_run = 0;  ///< packets without contents right before `at`
  while (at < end) {
    if (end == size_ && end - at >= packet_header_size && probe_.table_starts_at(at, probe_.bytes_at(at, end))) {
      found_packets.at_table = true;
      break;
    }
    if (const auto packet = probe_.header_at(at, end)) {
      if (packet->payload_size == 0) {
        ++found_packets.empty;
        ++empty_run;
      } else {
        if (empty_run >= zero_sector / packet_header_size) {
          found_packets.empty -= empty_run;
          found_packets.skipped += empty_run * packet_header_size;
        }
        empty_run = 0;
        found_packets.packets.push_back(*packet);
      }
      at = packet->payload_offset + packet->payload_size;
      continue;
    }
    // These zeros come from a power cut or a lost sector, or are a frame's end mark and the next packet's id.
    if (empty_run > 0) {
      found_packets.empty -= empty_run;
      at -= empty_run * packet_header_size;
    }
    empty_run = 0;
    if (!hints) hints = table == nullptr ? std::vector<PacketRecord>{} : hints_from(*table);
    const auto next = resume(found_packets, at, end, *hints);
    if (!next) break;
    at = *next;
  }
  if (end == size_ && !found_packets.at_table && empty_run > 1) {
    found_packets.empty -= empty_run;
    at -= empty_run * packet_header_size;
  }
  found_packets.end = at;
  return found_packets;
}

/// The place of the next packet, or of the data table, after bytes that cannot be a packet. Counts the bytes between.
std::optional<std::uint64_t> PacketFinder::resume(FoundPackets& found_packets, std::uint64_t at, std::uint64_t end,
                                                  const std::vector<PacketRecord>& hints) {
  if (const auto next = resume_by_table(found_packets, at, end, hints)) return next;
  // A wrong size of the packet before may have led here, so the search begins inside that packet.
  PacketRecord* before = found_packets.packets.empty() ? nullptr : &found_packets.packets.back();
  const bool adjacent = before != nullptr && before->payload_offset + before->payload_size == at;
  const std::uint64_t from = adjacent ? before->payload_offset : at + 1;
  const auto next = probe_.search(from, end, found_packets.packets.size());
  if (!next) return std::nullopt;
  const auto resized_to_next = [&] {
    PacketRecord packet = *before;
    packet.payload_size = static_cast<std::uint32_t>(*next - packet.payload_offset);
    return packet;
  };
  if (adjacent && *next == from) {  // it was not a packet
    found_packets.skipped += packet_header_size;
    found_packets.packets.pop_back();
  } else if (*next < at || (adjacent && *next - from <= std::numeric_limits<std::int32_t>::max() && !probe_.is_whole(*before) &&
                            probe_.is_whole(resized_to_next()))) {
    *before = resized_to_next();
    ++found_packets.resized;
  } else {
    found_packets.skipped += *next - at;
  }
  return next;
}

std::optional<std::uint64_t> PacketFinder::resume_by_table(FoundPackets& found_packets, std::uint64_t at, std::uint64_t end,
                                                           const std::vector<PacketRecord>& hints) {
  const auto from_offset = [&](std::uint64_t offset) {
    return std::lower_bound(hints.begin(), hints.end(), offset,
                            [](const PacketRecord& hint, std::uint64_t wanted) { return hint.payload_offset < wanted; });
  };
  const auto end_of = [](const PacketRecord& hint) { return hint.payload_offset + hint.payload_size; };
  const auto is_sound = [&](const PacketRecord& hint) {
    if (header_.declared(hint.stream_id) == nullptr || hint.payload_offset > end || hint.payload_size > end - hint.payload_offset)
      return false;
    if (!probe_.must_be_payload(probe_.bytes_at(hint.payload_offset, end, 12), hint)) return false;
    const std::uint64_t next_payload = end_of(hint) + packet_header_size;
    const auto next = from_offset(next_payload);
    return end_of(hint) == end || probe_.header_at(end_of(hint), end).has_value() ||
           (next != hints.end() && next->payload_offset == next_payload);
  };
  if (hints.empty()) return std::nullopt;
  if (!found_packets.packets.empty()) {
    PacketRecord& before = found_packets.packets.back();
    const auto hint = from_offset(before.payload_offset);
    if (hint != hints.end() && hint->payload_offset == before.payload_offset && hint->payload_size != before.payload_size &&
        is_sound(*hint)) {
      before.payload_size = hint->payload_size;
      ++found_packets.resized;
      return end_of(*hint);
    }
  }
  auto hint = from_offset(at + packet_header_size);
  if (hint != hints.end() && hint->payload_offset == at + packet_header_size && is_sound(*hint)) {
    found_packets.packets.push_back(
        {.stream_id = hint->stream_id, .payload_offset = hint->payload_offset, .payload_size = hint->payload_size});
    found_packets.skipped += packet_header_size;
    return end_of(*hint);
  }
  for (; hint != hints.end(); ++hint) {
    const std::uint64_t place = hint->payload_offset - packet_header_size;
    if (place <= at) continue;
    if (place >= end) break;
    const auto header = probe_.header_at(place, end);
    if (!header || header->stream_id != hint->stream_id || header->payload_size != hint->payload_size) continue;
    found_packets.skipped += place - at;
    return place;
  }
  return std::nullopt;
}

/// How the table's entries differ from the packets' own headers, or are impossible; empty if they agree.
std::string PacketFinder::disagreement(const std::vector<PacketRecord>& entries, const FoundPackets& found_packets) const {
  auto packet = found_packets.packets.begin();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const PacketRecord& entry = entries[i];
    if (entry.payload_size == 0) continue;
    if (packet == found_packets.packets.end())
      return fmt::format("it lists more packets than the {} that the file has", found_packets.packets.size());
    // One known writer gives the place of the packet's header instead of its contents.
    const bool same_place =
        entry.payload_offset == packet->payload_offset || entry.payload_offset == packet->payload_offset - packet_header_size;
    if (!same_place || entry.stream_id != packet->stream_id || entry.payload_size != packet->payload_size) {
      return fmt::format("its entry {} does not agree with the packet at byte {}", i,
                         packet->payload_offset - packet_header_size);
    }
    const Stream* stream = header_.declared(entry.stream_id);
    std::size_t most = std::numeric_limits<std::int64_t>::max();
    if (stream != nullptr && stream->type != StreamType::other) {
      const std::size_t bytes = largest_content(header_.compression, entry.payload_size);
      most = stream->type == StreamType::events ? bytes / sizeof(Event) : stream->type == StreamType::frames ? 1 : bytes / 8;
    }
    if (entry.elements < 0 || static_cast<std::uint64_t>(entry.elements) > most) {
      return fmt::format("its entry {} claims {} elements in {} bytes", i, entry.elements, entry.payload_size);
    }
    if (entry.elements > 0 && entry.last < entry.first) return fmt::format("its entry {} ends before it begins", i);
    ++packet;
  }
  if (packet != found_packets.packets.end()) {
    return fmt::format("it lists {} packets where the file has {}", packet - found_packets.packets.begin(),
                       found_packets.packets.size());
  }
  return {};
}

/// Counts the table's packets that the file lacks. Stream and size identify a packet: once bytes are lost, its place does not.
void PacketFinder::count_missing(const std::vector<PacketRecord>& entries, const FoundPackets& found_packets) {
  std::map<std::pair<std::int32_t, std::uint32_t>, std::uint64_t> there;
  for (const PacketRecord& packet : found_packets.packets) ++there[{packet.stream_id, packet.payload_size}];
  for (const PacketRecord& entry : entries) {
    if (entry.payload_size == 0) continue;
    const auto packet = there.find({entry.stream_id, entry.payload_size});
    if (packet != there.end() && packet->second > 0) {
      --packet->second;
      continue;
    }
    ++list_.problems.missing_packets;
    const auto most = static_cast<std::int64_t>(largest_content(header_.compression, entry.payload_size));
    list_.problems.missing_elements += static_cast<std::uint64_t>(std::clamp<std::int64_t>(entry.elements, 0, most));
  }
}

void PacketFinder::take(FoundPackets found_packets) {
  list_.problems.empty_packets = found_packets.empty;
  list_.problems.skipped_bytes = found_packets.skipped;
  list_.problems.resized_packets = found_packets.resized;
  const auto is_undeclared = [this](const PacketRecord& packet) { return header_.declared(packet.stream_id) == nullptr; };
  list_.problems.undeclared_packets = std::erase_if(found_packets.packets, is_undeclared);
  list_.packets = std::move(found_packets.packets);
}

/// Completes the packets by the table's entries, which agree with them.
void PacketFinder::take_table(const std::vector<PacketRecord>& entries) {
  list_.index = PacketIndex::table;
  auto packet = list_.packets.begin();
  for (const PacketRecord& entry : entries) {
    if (entry.payload_size == 0 || header_.declared(entry.stream_id) == nullptr) continue;
    packet->elements = entry.elements;
    packet->first = entry.first;
    packet->last = entry.last;
    ++packet;
  }
}

}  // namespace

PacketList find_packets(const RecordingFile& file, const RecordingStart& start) { return PacketFinder(file, start).find(); }

}  // namespace tactile::events
