#include "tactile/events/packet_writer.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstring>

#include "tactile/core/error.hpp"

namespace tactile::events {

PacketWriter::PacketWriter(const std::filesystem::path& file, const std::string& name, Compression compression,
                           std::span<const Stream> streams)
    : name_(name), out_(file, std::ios::binary), compression_(compression), header_(header_image(compression, streams)) {
  put(magic_line);
  put(header_.bytes);
  table_ = PacketTable(written_);
}

void PacketWriter::write(PacketRecord record, std::span<const std::byte> payload) {
  record.payload_size = static_cast<std::uint32_t>(payload.size());
  const std::int32_t head[2] = {record.stream_id, static_cast<std::int32_t>(record.payload_size)};
  put({reinterpret_cast<const char*>(head), sizeof head});
  put(payload);
  table_.add(record);
}

void PacketWriter::write_content(const PacketRecord& record, PacketBuffer& content, std::size_t size) {
  write(record, stored_form({content.data(), size}));
}

void PacketWriter::close() {
  const std::uint64_t table_position = written_;
  compressor_.compress_pieces(
      compression_, table_.content_size(), [&](const ByteSink& sink) { table_.write_contents(sink); },
      [&](std::span<const std::byte> piece) { put(piece); });
  out_.seekp(static_cast<std::streamoff>(magic_line.size() + header_.table_position));
  out_.write(reinterpret_cast<const char*>(&table_position), sizeof table_position);
  out_.close();
  if (!out_) fail();
}

std::span<const std::byte> PacketWriter::stored_form(std::span<const std::byte> content) {
  if (compression_ == Compression::none) return content;
  const std::size_t size = compressor_.compress(compression_, content, stored_, 0);
  return {stored_.data(), size};
}

void PacketWriter::put(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) fail();
  written_ += bytes.size();
}

void PacketWriter::put(std::span<const std::byte> bytes) {
  put(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void PacketWriter::fail() const {
  throw Error(fmt::format("{}: cannot be written ({}); expected a writable place with room", name_, std::strerror(errno)));
}

}  // namespace tactile::events
