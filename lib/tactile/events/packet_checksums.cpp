#include "tactile/events/packet_checksums.hpp"

#include <fcntl.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "tactile/events/recording_file.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view first_line = "#!TACTILE-CRC1\r\n";
constexpr std::size_t record_size = 24, own_at = 20;
constexpr std::size_t longest_header = std::size_t{16} << 20;
enum Kind : std::uint32_t { header_kind, packet_kind, end_kind };

std::uint32_t crc_of(std::span<const std::byte> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// The checksum of a recording's bytes before its first packet, without the table's position.
std::uint32_t crc_of_header(std::vector<std::byte> bytes, std::size_t table_position) {
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(table_position), sizeof(std::int64_t), std::byte{0xFF});
  return crc_of(bytes);
}

}  // namespace

fs::path checksums_beside(const fs::path& recording) { return recording.string() + ".checksums"; }

PacketChecksumWriter::PacketChecksumWriter(const fs::path& file)
    : file_(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (file_.is_open() && !file_.write_at(0, std::as_bytes(std::span(first_line)))) file_.reset();
  end_ = first_line.size();
}

void PacketChecksumWriter::add_header(std::span<const std::byte> bytes, std::size_t table_position) {
  add(table_position, bytes.size(), header_kind, crc_of_header({bytes.begin(), bytes.end()}, table_position));
}

void PacketChecksumWriter::add_packet(std::uint64_t position, std::span<const std::byte> bytes) {
  if (file_.is_open()) add(position, bytes.size(), packet_kind, crc_of(bytes));
}

void PacketChecksumWriter::add_end(std::uint64_t position) { add(position, 0, end_kind, 0); }

void PacketChecksumWriter::sync() {
  if (!file_.is_open() || ::fdatasync(file_.number()) == 0 || errno == EINVAL || errno == EROFS) return;
  file_.reset();
}

void PacketChecksumWriter::add(std::uint64_t position, std::size_t size, std::uint32_t kind, std::uint32_t checksum) {
  if (!file_.is_open()) return;
  std::array<std::byte, record_size> record{};
  const auto put = [&](std::size_t at, const auto& value) { std::memcpy(record.data() + at, &value, sizeof value); };
  put(0, position);
  put(8, static_cast<std::uint32_t>(size));
  put(12, kind);
  put(16, checksum);
  put(own_at, crc_of(std::span(record).first(own_at)));
  if (file_.write_at(end_, record)) {
    end_ += record_size;
  } else {
    file_.reset();
  }
}

struct PacketChecksums::Record {
  std::uint64_t position = 0;
  std::uint32_t size = 0, kind = 0, checksum = 0;
};

PacketChecksums::PacketChecksums(const RecordingReader& recording)
    : file_(::open(checksums_beside(recording.file()).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (file_.is_open()) find_header_and_end(recording);
}

/// The next valid record; false at the end of the file, or if it cannot be read.
bool PacketChecksums::next(Record& record) {
  for (;;) {
    if (read_size_ - used_ < record_size) {
      const std::ptrdiff_t got = file_.read_at(first_line.size() + read_end_, read_);
      if (got < static_cast<std::ptrdiff_t>(record_size)) return false;
      read_size_ = static_cast<std::size_t>(got) / record_size * record_size;
      read_end_ += read_size_;
      used_ = 0;
    }
    const std::span<const std::byte> bytes = std::span(read_).subspan(used_, record_size);
    used_ += record_size;
    if (u32_at(bytes, own_at) != crc_of(bytes.first(own_at))) continue;
    std::memcpy(&record.position, bytes.data(), sizeof record.position);
    record.size = u32_at(bytes, 8);
    record.kind = u32_at(bytes, 12);
    record.checksum = u32_at(bytes, 16);
    return true;
  }
}

void PacketChecksums::find_header_and_end(const RecordingReader& recording) {
  std::optional<Record> header, end;
  for (Record record; next(record);) {
    if (record.kind == header_kind) header = record;
    if (record.kind == end_kind) end = record;
  }
  read_size_ = used_ = 0;
  read_end_ = 0;
  const auto packets = recording.packets();
  const std::uint64_t packets_end = packets.empty() ? 0 : packets.back().payload_offset + packets.back().payload_size;
  const bool was_closed = recording.index() == PacketIndex::table && !recording.problems().header_not_patched;
  if (was_closed && (!end || end->position != packets_end)) return file_.reset();

  const RecordingFile file(recording.file());
  if (!header || header->size > std::min<std::uint64_t>(file.size(), longest_header) || header->size < sizeof(std::int64_t) ||
      header->position > header->size - sizeof(std::int64_t)) {
    return;
  }
  std::vector<std::byte> bytes(header->size);
  file.read(0, bytes);
  header_damaged_ = crc_of_header(std::move(bytes), static_cast<std::size_t>(header->position)) != header->checksum;
}

PacketCheck PacketChecksums::check(const PacketRecord& packet, std::span<const std::byte> stored) {
  if (!used()) return PacketCheck::not_covered;
  const std::uint64_t position = packet.payload_offset - packet_header_size;
  while (!has_record_ || position_ < position) {
    Record record;
    if (!next(record)) return PacketCheck::not_covered;
    if (record.kind != packet_kind) continue;
    position_ = record.position;
    size_ = record.size;
    checksum_ = record.checksum;
    has_record_ = true;
  }
  if (position_ != position) return PacketCheck::not_covered;
  // The packet's header as the reader understands it: it may have corrected a wrong size.
  std::array<std::byte, packet_header_size> packet_header{};
  std::memcpy(packet_header.data(), &packet.stream_id, sizeof packet.stream_id);
  std::memcpy(packet_header.data() + sizeof packet.stream_id, &packet.payload_size, sizeof packet.payload_size);
  const bool same = size_ == packet_header_size + stored.size() && crc_of(stored, crc_of(packet_header)) == checksum_;
  return same ? PacketCheck::whole : PacketCheck::damaged;
}

}  // namespace tactile::events
