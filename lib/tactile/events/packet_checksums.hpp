#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// A recording that is being written has no hash yet. A file next to it has a checksum of its header and of each packet:
///
///   the line "#!TACTILE-CRC1\r\n", then records of 24 bytes, little-endian:
///   uint64 position   packet: its start [B]; header: the place of the data table's position; end: the end of the packets
///   uint32 size       of the header, or of the packet with its header of 8 bytes [B]; 0 for the end
///   uint32 kind       0 header, 1 packet, 2 end
///   uint32 checksum   CRC-32 of these bytes; the table's position in the header, which is written last, counts as -1
///   uint32 own        CRC-32 of the 20 bytes before, which detects a record that was not completely written
std::filesystem::path checksums_beside(const std::filesystem::path& recording);

/// Writes the checksums of a recording that is being written. If that fails, the following packets have no checksum, and the
/// recording is still written.
class PacketChecksumWriter {
 public:
  PacketChecksumWriter() = default;  ///< writes nothing
  explicit PacketChecksumWriter(const std::filesystem::path& file);

  void add_header(std::span<const std::byte> bytes, std::size_t table_position);
  void add_packet(std::uint64_t position, std::span<const std::byte> bytes);
  void add_end(std::uint64_t position);
  void sync();

 private:
  void add(std::uint64_t position, std::size_t size, std::uint32_t kind, std::uint32_t checksum);

  FileDescriptor file_;
  std::uint64_t end_ = 0;
};

enum class PacketCheck : std::uint8_t { whole, damaged, not_covered };

/// Compares a recording with its checksums. Missing or damaged checksums, and those of missing packets, are ignored: after a
/// power cut either file may be longer. Memory does not follow the file.
class PacketChecksums {
 public:
  /// Uses no checksums if the file is missing or belongs to another recording: if the header names a data table, the recording
  /// was closed, and the checksums must end with its packets. @throws Error  if the recording cannot be read
  explicit PacketChecksums(const RecordingReader& recording);

  bool used() const { return file_.is_open(); }
  bool header_damaged() const { return header_damaged_; }

  /// Whether the packet is intact. Must be called in the order of the file.
  PacketCheck check(const PacketRecord& packet, std::span<const std::byte> stored);

 private:
  struct Record;

  bool next(Record& record);
  void find_header_and_end(const RecordingReader& recording);

  FileDescriptor file_;
  std::array<std::byte, std::size_t{24} * 2730> read_{};
  std::size_t read_size_ = 0, used_ = 0;
  std::uint64_t read_end_ = 0;
  std::uint64_t position_ = 0;  ///< of the packet whose record was read last
  std::uint32_t size_ = 0, checksum_ = 0;
  bool has_record_ = false;
  bool header_damaged_ = false;
};

}  // namespace tactile::events
