#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/recording_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// Looks at single places of a recording that may be damaged: is this a packet, is this the data table? `end` is where the
/// packets' part of the file ends at the latest [B].
class PacketProbe {
 public:
  PacketProbe(const RecordingFile& file, const RecordingStart& start);

  /// Up to `most` bytes of the file, as many as there are before `end`; valid until the next call.
  std::span<const std::byte> bytes_at(std::uint64_t at, std::uint64_t end, std::size_t most = longest_head);

  /// The packet that a header at `at` announces, if it can be one.
  std::optional<PacketRecord> header_at(std::uint64_t at, std::uint64_t end);
  /// The same, only if its contents and what follows it support that it is a packet.
  std::optional<PacketRecord> likely_packet_at(std::uint64_t at, std::uint64_t end);
  /// The first place from `from` on where a likely packet or the data table begins.
  std::optional<std::uint64_t> search(std::uint64_t from, std::uint64_t end, std::size_t packets_so_far);

  /// Whether the first bytes of the contents match everything that is known of this packet, whose stream must be declared.
  bool must_be_payload(std::span<const std::byte> payload, const PacketRecord& packet) const;
  /// Whether the contents prove that the packet is one, from its first byte to its last. Such proofs are limited in number: a
  /// file made of near misses costs no more than others.
  bool is_whole(const PacketRecord& packet);

  /// Reads the data table at `at`, which extends to the end of the file. @return  why it cannot be read; empty if it was read
  std::string read_table(std::uint64_t at, std::vector<PacketRecord>& entries);
  bool table_starts_at(std::uint64_t at, std::span<const std::byte> head);

  void release_memory() { content_ = {}, stored_ = {}; }

 private:
  static constexpr std::size_t longest_head = 20;  ///< a packet's header and the known start of its contents [B]

  bool may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const;
  bool is_likely_end(std::uint64_t at, std::uint64_t end);
  bool looks_like_table(std::span<const std::byte> head) const;

  const RecordingFile& file_;
  const RecordingHeader& header_;
  std::uint64_t data_begin_, size_;
  std::vector<std::string> identifiers_;  ///< of declared streams

  std::array<std::byte, 4096> window_{};  ///< of the file, where it was read last
  std::uint64_t window_at_ = 0;
  std::size_t window_size_ = 0;
  PacketBuffer stored_, content_, searched_;
  PacketDecompressor decompressor_;
  int failed_tables_ = 0;
  std::uint64_t proved_bytes_ = 0;
};

}  // namespace tactile::events
