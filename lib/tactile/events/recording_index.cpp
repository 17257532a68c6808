#include "tactile/events/recording_index.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t packet_header_size = 8;
constexpr std::size_t header_limit = std::size_t{16} << 20;  ///< no header we know has a hundredth of that [B]
constexpr std::size_t longest_head = 20;                     ///< a packet's header and what its contents must begin with [B]

constexpr std::uint64_t zero_sector = 512;  ///< so many zeros in a row are no packets without contents, but lost [B]

constexpr std::uint32_t lz4_magic = 0x184D2204;
constexpr std::uint32_t zstd_magic = 0xFD2FB528;
constexpr std::string_view table_identifier = "FTAB";

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

bool is_at(std::string_view letters, std::span<const std::byte> bytes, std::size_t at) {
  return bytes.size() >= at + letters.size() && std::memcmp(bytes.data() + at, letters.data(), letters.size()) == 0;
}

std::string quoted(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 40)) result += c >= ' ' && c <= '~' ? c : '?';
  return "'" + result + "'";
}

void refuse_magic(std::string_view start, const std::string& name) {
  if (start.empty()) throw Error(name + ": is empty; expected an AEDAT4 recording");
  if (start.starts_with("version https://git-lfs")) {
    throw Error(name + ": is a Git LFS pointer, not the recording itself; expected the file that 'git lfs pull' brings");
  }
  constexpr std::string_view aedat = "#!AER-DAT";
  if (start.starts_with(aedat) && !start.starts_with("#!AER-DAT4.0")) {
    const auto version = start.substr(aedat.size(), start.find_first_of("\r\n ") - aedat.size());
    throw Error(name + ": is of AEDAT version " + quoted(version) + "; expected version 4.0");
  }
  throw Error(name + ": starts with " + quoted(start.substr(0, magic_line.size())) +
              "; expected the line #!AER-DAT4.0 of an AEDAT4 recording");
}

/// The packets from the first on, as their headers tell.
struct Walk {
  std::vector<PacketRecord> packets;  ///< with contents, declared or not
  std::uint64_t end = 0;              ///< where the last one ends [B]
  std::uint64_t empty = 0;
  std::uint64_t skipped = 0;  ///< between packets [B]
  std::uint64_t resized = 0;  ///< packets whose own header has another size
  bool at_table = false;      ///< it ended before a data table

  bool damaged() const { return skipped > 0 || resized > 0; }
};

class PacketFinder {
 public:
  PacketFinder(const RecordingFile& file, const RecordingStart& start)
      : file_(file), header_(start.header), data_begin_(start.data_begin), size_(file.size()) {
    for (const Stream& stream : header_.streams) {
      if (stream.type_identifier.size() == 4) identifiers_.push_back(stream.type_identifier);
    }
  }

  PacketList find();

 private:
  const Stream* declared(std::int32_t id) const;
  std::span<const std::byte> bytes_at(std::uint64_t at, std::uint64_t end, std::size_t most = longest_head);

  std::string read_table(std::uint64_t at, std::vector<PacketRecord>& entries);
  bool looks_like_table(std::span<const std::byte> head) const;
  bool table_starts_at(std::uint64_t at, std::span<const std::byte> head);
  std::string disagreement(const std::vector<PacketRecord>& entries, const Walk& walked) const;
  std::vector<PacketRecord> hints_from(std::vector<PacketRecord> entries);

  Walk walk(std::uint64_t end, const std::vector<PacketRecord>* table = nullptr);
  std::optional<std::uint64_t> go_on(Walk& walked, std::uint64_t at, std::uint64_t end, const std::vector<PacketRecord>& hints);
  std::optional<std::uint64_t> go_on_by_table(Walk& walked, std::uint64_t at, std::uint64_t end,
                                              const std::vector<PacketRecord>& hints);
  std::optional<std::uint64_t> search(std::uint64_t from, std::uint64_t end, std::size_t packets_so_far);
  std::optional<PacketRecord> header_at(std::uint64_t at, std::uint64_t end);
  std::optional<PacketRecord> likely_packet_at(std::uint64_t at, std::uint64_t end);
  bool may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const;
  bool must_be_payload(std::span<const std::byte> payload, const PacketRecord& packet) const;
  bool is_likely_end(std::uint64_t at, std::uint64_t end);
  bool is_whole(const PacketRecord& packet);

  void count_missing(const std::vector<PacketRecord>& entries, const Walk& walked);
  void take(Walk walked);
  void take_table(const std::vector<PacketRecord>& entries);

  const RecordingFile& file_;
  const RecordingHeader& header_;
  std::uint64_t data_begin_, size_;
  std::vector<std::string> identifiers_;  ///< of declared streams
  PacketList list_;

  std::array<std::byte, 4096> window_{};  ///< of the file, where it was read last
  std::uint64_t window_at_ = 0;
  std::size_t window_size_ = 0;
  PacketBuffer stored_, content_, searched_;
  PacketDecompressor decompressor_;
  int failed_tables_ = 0;
  std::uint64_t proved_bytes_ = 0;
};

const Stream* PacketFinder::declared(std::int32_t id) const {
  const auto found = std::find_if(header_.streams.begin(), header_.streams.end(), [id](const Stream& s) { return s.id == id; });
  return found == header_.streams.end() ? nullptr : &*found;
}

/// Up to `most` bytes of the file, as many as there are before `end`; valid until the next call.
std::span<const std::byte> PacketFinder::bytes_at(std::uint64_t at, std::uint64_t end, std::size_t most) {
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(most, end - at));
  if (at < window_at_ || at + wanted > window_at_ + window_size_) {
    // Small packets stand close together: a step that is short is likely to be followed by others.
    const bool near = at >= window_at_ && at - window_at_ < window_.size();
    window_size_ = 0;  // nothing, should the reading fail
    const auto room = static_cast<std::size_t>(std::min<std::uint64_t>(near ? window_.size() : longest_head, size_ - at));
    file_.read(at, std::span(window_).first(room));
    window_at_ = at;
    window_size_ = room;
  }
  return std::span<const std::byte>(window_).subspan(static_cast<std::size_t>(at - window_at_), wanted);
}

PacketList PacketFinder::find() {
  std::vector<PacketRecord> entries;
  std::string& why = list_.problems.table;
  const std::int64_t position = header_.table_position;
  const bool has_position = position >= 0 || position < -2;  // -1: not closed, -2: jAER's mark for the same
  std::optional<std::uint64_t> table_at;
  std::optional<Walk> walked;
  if (has_position) {
    const auto announced = static_cast<std::uint64_t>(position);
    if (position < 0 || announced < data_begin_ || announced >= size_) {
      why = fmt::format("its position {} lies outside the packets' part of the file, {} to {}", position, data_begin_, size_);
    } else {
      why = read_table(announced, entries);
      if (why.empty()) table_at = announced;
    }
  }
  content_ = {}, stored_ = {};  // the table may be as large as all entries
  if (!table_at) {
    walked = walk(size_);
    if (!walked->at_table) {
      list_.problems.truncated_bytes = size_ - walked->end;
    } else if (!has_position) {
      why = read_table(walked->end, entries);
      if (why.empty()) table_at = walked->end;
    }
  }
  if (table_at && (!walked || walked->damaged())) {
    walked = walk(*table_at, &entries);
    walked->skipped += *table_at - walked->end;
  }
  if (table_at) {
    why = walked->damaged() ? "packets before it are damaged" : disagreement(entries, *walked);
    if (!why.empty()) count_missing(entries, *walked);
  }
  take(std::move(*walked));
  if (table_at && why.empty()) {
    take_table(entries);
    list_.problems.header_not_patched = !has_position;
  }
  return std::move(list_);
}

/// The data table at `at`, which runs to the end of the file; returns why it cannot be had, or nothing.
std::string PacketFinder::read_table(std::uint64_t at, std::vector<PacketRecord>& entries) {
  const std::uint64_t room = size_ - at;
  const std::span<const std::byte> head = bytes_at(at, size_, 12);
  if (head.size() < 12) return "it is cut off";
  const bool plain = is_at(table_identifier, head, 8);
  const std::uint32_t magic = u32_at(head, 0);
  if (!plain && magic != lz4_magic && magic != zstd_magic) return fmt::format("there is none at its position {}", at);

  // Every packet takes 9 bytes at least and its entry some 50, so a table cannot be longer than this.
  const std::uint64_t limit =
      std::min<std::uint64_t>((at - data_begin_) / 9 * 128 + 4096, std::numeric_limits<std::int32_t>::max() - 64);
  if (room > limit) return fmt::format("it has {} bytes for packets of {}", room, at - data_begin_);
  PacketBuffer& raw = plain ? content_ : stored_;
  raw.grow(static_cast<std::size_t>(room), 0);
  const std::span<std::byte> bytes(raw.data(), static_cast<std::size_t>(room));
  file_.read(at, bytes);
  std::size_t table_size = bytes.size();
  if (!plain) {
    const Compression method = magic == lz4_magic ? Compression::lz4 : Compression::zstd;
    const Decompressed result = decompressor_.decompress(method, bytes, content_, static_cast<std::size_t>(limit));
    if (!result.whole) return "it does not decompress";
    table_size = result.size;
  }
  return decode_table(content_, table_size, entries) == Contents::whole ? "" : "it does not decode as an FTAB table";
}

bool PacketFinder::looks_like_table(std::span<const std::byte> head) const {
  if (head.size() < 4) return false;
  const std::uint32_t magic = u32_at(head, 0);
  return is_at(table_identifier, head, 8) ||
         ((magic == lz4_magic || magic == zstd_magic) && declared(static_cast<std::int32_t>(magic)) == nullptr);
}

bool PacketFinder::table_starts_at(std::uint64_t at, std::span<const std::byte> head) {
  if (!looks_like_table(head)) return false;
  if (static_cast<std::int64_t>(at) == header_.table_position) return true;  // sound or not, the header says so too
  constexpr int most_failures = 8;                                           // each has read the rest of the file
  if (failed_tables_ == most_failures) return false;
  std::vector<PacketRecord> ignored;
  if (read_table(at, ignored).empty()) return true;
  ++failed_tables_;
  return false;
}

/// The table's entries as the places of packets to go by: in ascending order, or none. One known writer gives where the packet's
/// header stands, not what is behind it; the headers that are sound tell which.
std::vector<PacketRecord> PacketFinder::hints_from(std::vector<PacketRecord> entries) {
  std::erase_if(entries, [](const PacketRecord& entry) { return entry.payload_size == 0; });
  const auto agree = [&](std::uint64_t back) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(entries.size(), 64); ++i) {
      const PacketRecord& entry = entries[i];
      if (entry.payload_offset < data_begin_ + back) continue;
      const auto header = entry.payload_offset - back < size_ ? header_at(entry.payload_offset - back, size_) : std::nullopt;
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

/// From header to header up to `end` or a data table; where there is damage, by what the entries of `table` tell too.
Walk PacketFinder::walk(std::uint64_t end, const std::vector<PacketRecord>* table) {
  Walk walked;
  std::optional<std::vector<PacketRecord>> hints;  // once they are wanted, for they take memory
  if (table != nullptr) walked.packets.reserve(table->size());
  std::uint64_t at = data_begin_;
  std::uint64_t empty_run = 0;  ///< packets without contents right before `at`
  while (at < end) {
    if (end == size_ && end - at >= packet_header_size && table_starts_at(at, bytes_at(at, end))) {
      walked.at_table = true;
      break;
    }
    if (const auto packet = header_at(at, end)) {
      if (packet->payload_size == 0) {
        ++walked.empty;
        ++empty_run;
      } else {
        if (empty_run >= zero_sector / packet_header_size) {
          walked.empty -= empty_run;
          walked.skipped += empty_run * packet_header_size;
        }
        empty_run = 0;
        walked.packets.push_back(*packet);
      }
      at = packet->payload_offset + packet->payload_size;
      continue;
    }
    // Zeros that a power cut or a lost sector left behind, or one frame's end mark and the next packet's id.
    if (empty_run > 0) {
      walked.empty -= empty_run;
      at -= empty_run * packet_header_size;
    }
    empty_run = 0;
    if (!hints) hints = table == nullptr ? std::vector<PacketRecord>{} : hints_from(*table);
    const auto next = go_on(walked, at, end, *hints);
    if (!next) break;
    at = *next;
  }
  if (end == size_ && !walked.at_table && empty_run > 1) {
    walked.empty -= empty_run;
    at -= empty_run * packet_header_size;
  }
  walked.end = at;
  return walked;
}

/// The packet that a header at `at` announces, if it can be one.
std::optional<PacketRecord> PacketFinder::header_at(std::uint64_t at, std::uint64_t end) {
  const std::span<const std::byte> head = bytes_at(at, end, packet_header_size + 4);
  if (head.size() < packet_header_size) return std::nullopt;
  const auto id = static_cast<std::int32_t>(u32_at(head, 0));
  const std::uint32_t payload_size = u32_at(head, 4);
  if (payload_size > std::numeric_limits<std::int32_t>::max() || payload_size > end - at - packet_header_size)
    return std::nullopt;
  if (declared(id) == nullptr && !may_be_payload(head.subspan(packet_header_size), payload_size)) return std::nullopt;
  return PacketRecord{.stream_id = id, .payload_offset = at + packet_header_size, .payload_size = payload_size};
}

/// Whether these first bytes can begin a packet's contents: what an undeclared stream's packet must show to be believed.
bool PacketFinder::may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const {
  if (payload_size < 12 || payload.size() < 4) return false;
  const std::uint32_t first = u32_at(payload, 0);
  switch (header_.compression) {
    case Compression::none:
      return first <= payload_size - 4 && first >= 8;
    case Compression::lz4:
    case Compression::lz4_high:
      return first == lz4_magic;
    case Compression::zstd:
    case Compression::zstd_high:
      return first == zstd_magic;
  }
  return false;
}

/// Likewise, of a declared stream, with all that can be told.
bool PacketFinder::must_be_payload(std::span<const std::byte> payload, const PacketRecord& packet) const {
  const Stream* stream = declared(packet.stream_id);
  if (stream == nullptr || !may_be_payload(payload, packet.payload_size)) return false;
  return header_.compression != Compression::none || is_at(stream->type_identifier, payload, 8);
}

/// Past what can be no packet: the place of the next one, or of the data table. Counts what lies between.
std::optional<std::uint64_t> PacketFinder::go_on(Walk& walked, std::uint64_t at, std::uint64_t end,
                                                 const std::vector<PacketRecord>& hints) {
  if (const auto next = go_on_by_table(walked, at, end, hints)) return next;
  // The size of the packet before may be what led here, so the search begins inside of it.
  PacketRecord* before = walked.packets.empty() ? nullptr : &walked.packets.back();
  const bool adjacent = before != nullptr && before->payload_offset + before->payload_size == at;
  const std::uint64_t from = adjacent ? before->payload_offset : at + 1;
  const auto next = search(from, end, walked.packets.size());
  if (!next) return std::nullopt;
  const auto as_long_as_that = [&] {
    PacketRecord packet = *before;
    packet.payload_size = static_cast<std::uint32_t>(*next - packet.payload_offset);
    return packet;
  };
  if (adjacent && *next == from) {  // it was no packet at all
    walked.skipped += packet_header_size;
    walked.packets.pop_back();
  } else if (*next < at || (adjacent && *next - from <= std::numeric_limits<std::int32_t>::max() && !is_whole(*before) &&
                            is_whole(as_long_as_that()))) {
    *before = as_long_as_that();
    ++walked.resized;
  } else {
    walked.skipped += *next - at;
  }
  return next;
}

std::optional<std::uint64_t> PacketFinder::go_on_by_table(Walk& walked, std::uint64_t at, std::uint64_t end,
                                                          const std::vector<PacketRecord>& hints) {
  const auto from_offset = [&](std::uint64_t offset) {
    return std::lower_bound(hints.begin(), hints.end(), offset,
                            [](const PacketRecord& hint, std::uint64_t wanted) { return hint.payload_offset < wanted; });
  };
  const auto end_of = [](const PacketRecord& hint) { return hint.payload_offset + hint.payload_size; };
  const auto is_sound = [&](const PacketRecord& hint) {
    if (declared(hint.stream_id) == nullptr || hint.payload_offset > end || hint.payload_size > end - hint.payload_offset)
      return false;
    if (!must_be_payload(bytes_at(hint.payload_offset, end, 12), hint)) return false;
    const std::uint64_t behind = end_of(hint) + packet_header_size;
    const auto next = from_offset(behind);
    return end_of(hint) == end || header_at(end_of(hint), end).has_value() ||
           (next != hints.end() && next->payload_offset == behind);
  };
  if (hints.empty()) return std::nullopt;
  if (!walked.packets.empty()) {
    PacketRecord& before = walked.packets.back();
    const auto hint = from_offset(before.payload_offset);
    if (hint != hints.end() && hint->payload_offset == before.payload_offset && hint->payload_size != before.payload_size &&
        is_sound(*hint)) {
      before.payload_size = hint->payload_size;
      ++walked.resized;
      return end_of(*hint);
    }
  }
  auto hint = from_offset(at + packet_header_size);
  if (hint != hints.end() && hint->payload_offset == at + packet_header_size && is_sound(*hint)) {
    walked.packets.push_back(
        {.stream_id = hint->stream_id, .payload_offset = hint->payload_offset, .payload_size = hint->payload_size});
    walked.skipped += packet_header_size;
    return end_of(*hint);
  }
  for (; hint != hints.end(); ++hint) {
    const std::uint64_t place = hint->payload_offset - packet_header_size;
    if (place <= at) continue;
    if (place >= end) break;
    const auto header = header_at(place, end);
    if (!header || header->stream_id != hint->stream_id || header->payload_size != hint->payload_size) continue;
    walked.skipped += place - at;
    return place;
  }
  return std::nullopt;
}

/// The first place from `from` on where a packet or the data table stands.
std::optional<std::uint64_t> PacketFinder::search(std::uint64_t from, std::uint64_t end, std::size_t packets_so_far) {
  constexpr std::size_t chunk = std::size_t{1} << 20;
  const bool compressed = header_.compression != Compression::none;
  const std::uint32_t magic =
      header_.compression == Compression::lz4 || header_.compression == Compression::lz4_high ? lz4_magic : zstd_magic;
  // A table long enough for packets that were passed over, not for any number of them: an attempt to read one costs its length.
  const std::uint64_t table_limit = (std::uint64_t{1} << 16) + 256 * std::uint64_t{packets_so_far};
  const std::uint64_t first = from;
  searched_.grow(static_cast<std::size_t>(std::min<std::uint64_t>(chunk, size_ - from)), 0);
  while (end > from && end - from >= packet_header_size + 4) {
    const std::span<std::byte> bytes(searched_.data(), static_cast<std::size_t>(std::min<std::uint64_t>(chunk, end - from)));
    file_.read(from, bytes);
    const std::size_t places = bytes.size() - std::min(bytes.size(), longest_head - 1);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::uint64_t place = from + i;
      if (compressed) {  // the table's first bytes, or a packet's behind its header
        const void* found = memmem(bytes.data() + i, bytes.size() - i, &magic, sizeof magic);
        if (found == nullptr) break;
        i = static_cast<std::size_t>(static_cast<const std::byte*>(found) - bytes.data());
        const std::uint64_t contents = from + i;
        if (contents >= first + packet_header_size && likely_packet_at(contents - packet_header_size, end))
          return contents - packet_header_size;
        if (end == size_ && size_ - contents <= table_limit && table_starts_at(contents, bytes_at(contents, end)))
          return contents;
        continue;
      }
      if (i >= places) break;
      const std::span<const std::byte> here = bytes.subspan(i);
      const bool is_packet = std::any_of(identifiers_.begin(), identifiers_.end(),
                                         [&](const std::string& identifier) { return is_at(identifier, here, 16); });
      if (is_packet && likely_packet_at(place, end)) return place;
      if (end == size_ && size_ - place <= table_limit && is_at(table_identifier, here, 8) && table_starts_at(place, here))
        return place;
    }
    if (bytes.size() == end - from) break;
    from += bytes.size() - (longest_head - 1);
  }
  return std::nullopt;
}

/// A packet at `at`, if everything speaks for it.
std::optional<PacketRecord> PacketFinder::likely_packet_at(std::uint64_t at, std::uint64_t end) {
  const auto packet = header_at(at, end);
  if (!packet || !must_be_payload(bytes_at(packet->payload_offset, end, 12), *packet)) return std::nullopt;
  if (!is_likely_end(packet->payload_offset + packet->payload_size, end) && !is_whole(*packet)) return std::nullopt;
  return packet;
}

/// Whether a packet may end here: before another one, before the table, or with the data.
bool PacketFinder::is_likely_end(std::uint64_t at, std::uint64_t end) {
  if (at == end) return true;
  const auto header = header_at(at, end);
  if (header && header->payload_size > 0) return must_be_payload(bytes_at(header->payload_offset, end, 12), *header);
  return end == size_ && looks_like_table(bytes_at(at, end));
}

/// Whether the contents prove that the packet is one, from its first byte to its last. Such proofs are few, so that a file made
/// of near misses costs no more than others.
bool PacketFinder::is_whole(const PacketRecord& packet) {
  constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20;
  if (header_.compression == Compression::none) {
    const std::span<const std::byte> head = bytes_at(packet.payload_offset, size_, 4);
    return head.size() == 4 && std::uint64_t{u32_at(head, 0)} + 4 == packet.payload_size;
  }
  if (packet.payload_size > size_ - packet.payload_offset || proved_bytes_ + packet.payload_size > most_bytes) return false;
  proved_bytes_ += packet.payload_size;
  stored_.grow(packet.payload_size, 0);
  const std::span<std::byte> bytes(stored_.data(), packet.payload_size);
  file_.read(packet.payload_offset, bytes);
  const std::size_t limit = std::min(largest_content(header_.compression, bytes.size()), std::size_t{16} << 20);
  const Decompressed result = decompressor_.decompress(header_.compression, bytes, content_, limit);
  proved_bytes_ += result.whole ? result.size : limit;
  return result.whole;
}

/// Where the table's entries differ from what the packets' own headers say, or cannot be; nothing if they agree.
std::string PacketFinder::disagreement(const std::vector<PacketRecord>& entries, const Walk& walked) const {
  auto packet = walked.packets.begin();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const PacketRecord& entry = entries[i];
    if (entry.payload_size == 0) continue;
    if (packet == walked.packets.end())
      return fmt::format("it lists more packets than the {} that the file has", walked.packets.size());
    // One known writer gives where the packet's header stands, not what is behind it.
    const bool same_place =
        entry.payload_offset == packet->payload_offset || entry.payload_offset == packet->payload_offset - packet_header_size;
    if (!same_place || entry.stream_id != packet->stream_id || entry.payload_size != packet->payload_size) {
      return fmt::format("its entry {} does not agree with the packet at byte {}", i,
                         packet->payload_offset - packet_header_size);
    }
    const Stream* stream = declared(entry.stream_id);
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
  if (packet != walked.packets.end()) {
    return fmt::format("it lists {} packets where the file has {}", packet - walked.packets.begin(), walked.packets.size());
  }
  return {};
}

/// Counts the table's packets that are not there, each known by its stream and size: where it stood tells nothing once bytes
/// are gone from the file.
void PacketFinder::count_missing(const std::vector<PacketRecord>& entries, const Walk& walked) {
  std::map<std::pair<std::int32_t, std::uint32_t>, std::uint64_t> there;
  for (const PacketRecord& packet : walked.packets) ++there[{packet.stream_id, packet.payload_size}];
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

void PacketFinder::take(Walk walked) {
  list_.problems.empty_packets = walked.empty;
  list_.problems.skipped_bytes = walked.skipped;
  list_.problems.resized_packets = walked.resized;
  const auto is_undeclared = [this](const PacketRecord& packet) { return declared(packet.stream_id) == nullptr; };
  list_.problems.undeclared_packets = std::erase_if(walked.packets, is_undeclared);
  list_.packets = std::move(walked.packets);
}

/// Completes the packets by the table's entries, which agree with them.
void PacketFinder::take_table(const std::vector<PacketRecord>& entries) {
  list_.index = PacketIndex::table;
  auto packet = list_.packets.begin();
  for (const PacketRecord& entry : entries) {
    if (entry.payload_size == 0 || declared(entry.stream_id) == nullptr) continue;
    packet->elements = entry.elements;
    packet->first = entry.first;
    packet->last = entry.last;
    ++packet;
  }
}

}  // namespace

RecordingFile::RecordingFile(const fs::path& path)
    : name_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat status {};
  if (!file_.is_open() || ::fstat(file_.number(), &status) != 0) {
    throw Error(name_ + ": cannot be opened (" + std::strerror(errno) + "); expected an AEDAT4 recording");
  }
  if (!S_ISREG(status.st_mode)) throw Error(name_ + ": is no regular file; expected an AEDAT4 recording");
  size_ = static_cast<std::uint64_t>(status.st_size);
}

void RecordingFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  const std::ptrdiff_t got = file_.read_at(offset, bytes);
  if (got < 0) throw Error(name_ + ": cannot be read (" + std::strerror(errno) + "); expected a readable file");
  if (static_cast<std::size_t>(got) != bytes.size())
    throw Error(name_ + ": became shorter while it was read; expected it to stay as it is");
}

RecordingStart read_start(const RecordingFile& file) {
  std::array<std::byte, 64> start{};
  const auto start_size = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), start.size()));
  file.read(0, std::span(start).first(start_size));
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start_size);
  if (!text.starts_with(magic_line)) refuse_magic(text, file.name());

  const std::size_t header_at = magic_line.size();
  const std::uint64_t header_size = start_size < header_at + 4 ? file.size() : std::uint64_t{u32_at(start, header_at)} + 4;
  if (header_size > file.size() - header_at) {
    throw Error(file.name() + ": ends inside its header; expected a recording whose header was written whole");
  }
  if (header_size > header_limit) {
    throw Error(fmt::format("{}: claims a header of {} bytes; expected at most {}", file.name(), header_size, header_limit));
  }
  PacketBuffer buffer;
  buffer.grow(static_cast<std::size_t>(header_size), 0);
  const std::span<std::byte> bytes(buffer.data(), static_cast<std::size_t>(header_size));
  file.read(header_at, bytes);
  return {.header = read_header(bytes, file.name()), .data_begin = header_at + header_size};
}

PacketList find_packets(const RecordingFile& file, const RecordingStart& start) { return PacketFinder(file, start).find(); }

}  // namespace tactile
