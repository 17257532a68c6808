#include "tactile/events/packet_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>

#include "tactile/events/packet_contents.hpp"

namespace tactile::events {
namespace {

constexpr std::uint32_t lz4_magic = 0x184D2204;
constexpr std::uint32_t zstd_magic = 0xFD2FB528;
constexpr std::string_view table_identifier = "FTAB";

bool is_at(std::string_view letters, std::span<const std::byte> bytes, std::size_t at) {
  return bytes.size() >= at + letters.size() && std::memcmp(bytes.data() + at, letters.data(), letters.size()) == 0;
}

}  // namespace

PacketProbe::PacketProbe(const RecordingFile& file, const RecordingStart& start)
    : file_(file), header_(start.header), data_begin_(start.data_begin), size_(file.size()) {
  for (const Stream& stream : header_.streams) {
    if (stream.type_identifier.size() == 4) identifiers_.push_back(stream.type_identifier);
  }
}

std::span<const std::byte> PacketProbe::bytes_at(std::uint64_t at, std::uint64_t end, std::size_t most) {
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(most, end - at));
  if (at < window_at_ || at + wanted > window_at_ + window_size_) {
    // Small packets lie close together: after a short step others are likely to follow.
    const bool near = at >= window_at_ && at - window_at_ < window_.size();
    window_size_ = 0;  // in case reading fails
    const auto room = static_cast<std::size_t>(std::min<std::uint64_t>(near ? window_.size() : longest_head, size_ - at));
    file_.read(at, std::span(window_).first(room));
    window_at_ = at;
    window_size_ = room;
  }
  return std::span<const std::byte>(window_).subspan(static_cast<std::size_t>(at - window_at_), wanted);
}

std::optional<PacketRecord> PacketProbe::header_at(std::uint64_t at, std::uint64_t end) {
  const std::span<const std::byte> head = bytes_at(at, end, packet_header_size + 4);
  if (head.size() < packet_header_size) return std::nullopt;
  const auto id = static_cast<std::int32_t>(u32_at(head, 0));
  const std::uint32_t payload_size = u32_at(head, 4);
  if (payload_size > std::numeric_limits<std::int32_t>::max() || payload_size > end - at - packet_header_size)
    return std::nullopt;
  if (header_.declared(id) == nullptr && !may_be_payload(head.subspan(packet_header_size), payload_size)) return std::nullopt;
  return PacketRecord{.stream_id = id, .payload_offset = at + packet_header_size, .payload_size = payload_size};
}

/// Whether these first bytes can begin a packet's contents. For a packet of an undeclared stream this is the only evidence.
bool PacketProbe::may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const {
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

bool PacketProbe::must_be_payload(std::span<const std::byte> payload, const PacketRecord& packet) const {
  const Stream* stream = header_.declared(packet.stream_id);
  if (stream == nullptr || !may_be_payload(payload, packet.payload_size)) return false;
  return header_.compression != Compression::none || is_at(stream->type_identifier, payload, 8);
}

std::optional<PacketRecord> PacketProbe::likely_packet_at(std::uint64_t at, std::uint64_t end) {
  const auto packet = header_at(at, end);
  if (!packet || !must_be_payload(bytes_at(packet->payload_offset, end, 12), *packet)) return std::nullopt;
  if (!is_likely_end(packet->payload_offset + packet->payload_size, end) && !is_whole(*packet)) return std::nullopt;
  return packet;
}

/// Whether a packet may end here: before another one, before the table, or at the end of the data.
bool PacketProbe::is_likely_end(std::uint64_t at, std::uint64_t end) {
  if (at == end) return true;
  const auto header = header_at(at, end);
  if (header && header->payload_size > 0) return must_be_payload(bytes_at(header->payload_offset, end, 12), *header);
  return end == size_ && looks_like_table(bytes_at(at, end));
}

bool PacketProbe::is_whole(const PacketRecord& packet) {
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

std::string PacketProbe::read_table(std::uint64_t at, std::vector<PacketRecord>& entries) {
  const std::uint64_t room = size_ - at;
  const std::span<const std::byte> head = bytes_at(at, size_, 12);
  if (head.size() < 12) return "it is cut off";
  const bool plain = is_at(table_identifier, head, 8);
  const std::uint32_t magic = u32_at(head, 0);
  if (!plain && magic != lz4_magic && magic != zstd_magic) return fmt::format("there is none at its position {}", at);

  // A packet takes at least 9 bytes and its entry about 50, so a table cannot be longer than this.
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

bool PacketProbe::looks_like_table(std::span<const std::byte> head) const {
  if (head.size() < 4) return false;
  const std::uint32_t magic = u32_at(head, 0);
  return is_at(table_identifier, head, 8) ||
         ((magic == lz4_magic || magic == zstd_magic) && header_.declared(static_cast<std::int32_t>(magic)) == nullptr);
}

bool PacketProbe::table_starts_at(std::uint64_t at, std::span<const std::byte> head) {
  if (!looks_like_table(head)) return false;
  if (static_cast<std::int64_t>(at) == header_.table_position) return true;  // damaged or not, the header gives this place
  constexpr int most_failures = 8;                                           // each attempt reads the rest of the file
  if (failed_tables_ == most_failures) return false;
  std::vector<PacketRecord> ignored;
  if (read_table(at, ignored).empty()) return true;
  ++failed_tables_;
  return false;
}

std::optional<std::uint64_t> PacketProbe::search(std::uint64_t from, std::uint64_t end, std::size_t packets_so_far) {
  constexpr std::size_t chunk = std::size_t{1} << 20;
  const bool compressed = header_.compression != Compression::none;
  const std::uint32_t magic =
      header_.compression == Compression::lz4 || header_.compression == Compression::lz4_high ? lz4_magic : zstd_magic;
  // Long enough for the packets so far. Reading a table costs its length, so longer candidates are not tried.
  const std::uint64_t table_limit = (std::uint64_t{1} << 16) + 256 * std::uint64_t{packets_so_far};
  const std::uint64_t first = from;
  searched_.grow(static_cast<std::size_t>(std::min<std::uint64_t>(chunk, size_ - from)), 0);
  while (end > from && end - from >= packet_header_size + 4) {
    const std::span<std::byte> bytes(searched_.data(), static_cast<std::size_t>(std::min<std::uint64_t>(chunk, end - from)));
    file_.read(from, bytes);
    const std::size_t places = bytes.size() - std::min(bytes.size(), longest_head - 1);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::uint64_t place = from + i;
      if (compressed) {  // the first bytes of a table, or of a packet's contents
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

}  // namespace tactile::events
