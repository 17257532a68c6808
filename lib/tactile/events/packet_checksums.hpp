#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// A recording that is being written has no hash yet. A file beside it holds a checksum of its header and of each packet:
///
///   the line "#!TACTILE-CRC1\r\n", then records of 24 bytes, little-endian:
///   uint64 position   packet: where it begins [B]; header: where it has the data table's position; end: where the packets end
///   uint32 size       of the header, or of the packet with its 8 bytes in front [B]; 0 of the end
///   uint32 kind       0 header, 1 packet, 2 end
///   uint32 checksum   CRC-32 of these bytes; the table's position in the header, which is written last, counts as -1
///   uint32 own        CRC-32 of the 20 bytes before: a record that a kill or a power cut left torn has another one
std::filesystem::path checksums_beside(const std::filesystem::path& recording);

/// Writes the checksums of a recording that is being written. Where that fails it stops, and the recording is written on: the
/// packets from there on have no checksum.
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

/// Compares a recording with the checksums beside it. Those that are missing, torn or of what the recording does not have are
/// passed over: after a power cut either file may be the longer one. Memory does not follow the file.
class PacketChecksums {
 public:
  /// Uses none where the file is not there, or of another recording: one whose header leads to a data table was closed, and its
  /// checksums must end where its packets do. @throws Error if the recording cannot be read
  explicit PacketChecksums(const RecordingReader& recording);

  bool used() const { return file_.is_open(); }
  bool header_damaged() const { return header_damaged_; }

  /// Whether the packet is what was written. To be asked in the order of the file.
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

}  // namespace tactile
