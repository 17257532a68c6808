#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_table.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// Packets that wait for others, so that several threads compress them at the same time. They are written in the order in which
/// they came. One thread, or no compression, needs no waiting: then each packet is a batch.
class PacketBatch {
 public:
  PacketBatch(Compression compression, unsigned threads);

  bool is_full() const { return count_ == packets_.size() || waiting_bytes_ >= most_waiting_bytes; }
  /// Takes the contents of a packet, which begin after `packet_header_size` bytes (recording_header.hpp), and gives `content`
  /// other memory.
  /// @pre  not full
  void add(const PacketRecord& record, PacketBuffer& content, std::size_t content_size);

  /// Compresses all packets. Passes each to `write`, in order, while later ones are compressed: its record, and its bytes with
  /// the header. Any of the threads may call `write`. What it throws leaves this packet and the later ones in the batch.
  /// @throws Error  if the library fails
  void write_all(const std::function<void(const PacketRecord& record, std::span<const std::byte> bytes)>& write);

 private:
  static constexpr std::size_t most_waiting_bytes = std::size_t{16} << 20;  ///< of contents: frames can be large
  struct Packet {
    PacketRecord record;
    PacketBuffer content, stored;
    std::size_t content_size = 0, stored_size = 0;  ///< without the header
  };

  Compression compression_;
  std::vector<PacketCompressor> compressors_;  ///< of each thread
  std::vector<Packet> packets_;                ///< the first `count_` wait; the others' memory is reused
  std::size_t count_ = 0, waiting_bytes_ = 0;
};

}  // namespace tactile::events
