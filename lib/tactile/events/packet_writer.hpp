#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_table.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::events {

/// Writes an AEDAT4 recording packet by packet, in the order of the calls, with a data table. Stored packets of another recording
/// of the same compression can be copied as they are. Memory grows by the data table, about 7 bytes per packet.
class PacketWriter {
 public:
  /// @param file  a new file  @param name  of the file in errors
  PacketWriter(const std::filesystem::path& file, const std::string& name, Compression compression,
               std::span<const Stream> streams);

  /// One packet as it is stored; `record` gives its stream, the number of its elements and their times.
  void write(PacketRecord record, std::span<const std::byte> payload);
  /// The same for uncompressed contents, the first `size` bytes of `content`.
  void write_content(const PacketRecord& record, PacketBuffer& content, std::size_t size);

  void close();  ///< writes the data table, without sync. @throws Error  as every other function, if the disk is full

 private:
  std::span<const std::byte> stored_form(std::span<const std::byte> content);
  void put(std::string_view bytes);
  void put(std::span<const std::byte> bytes);
  [[noreturn]] void fail() const;

  std::string name_;
  std::ofstream out_;
  Compression compression_;
  HeaderImage header_;
  PacketCompressor compressor_;
  PacketBuffer stored_;
  PacketTable table_;
  std::uint64_t written_ = 0;
};

}  // namespace tactile::events
