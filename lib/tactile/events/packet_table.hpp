#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// The data table of a recording that is being written. A packet takes a few bytes, because only the differences to the packet
/// before it in its stream are stored: about 25 MB for an hour of packets of 1 ms. The memory is never copied to grow.
class PacketTable {
 public:
  /// @param begin  the place of the first packet's header in the file [B]
  explicit PacketTable(std::uint64_t begin = 0) : begin_(begin) {}

  /// Adds the next packet of the file. It begins at the end of the one before it; its `payload_offset` is not used.
  void add(const PacketRecord& packet);

  std::size_t packets() const { return packets_; }
  std::size_t held_bytes() const { return bytes_.size(); }  ///< memory for the packets

  // The FTAB contents of the file, with their size prefix.
  std::uint64_t content_size() const;          ///< [B]
  void write_contents(const ByteSink&) const;  ///< in pieces of at most 64 KiB; at most 40 million packets

 private:
  /// The last packet of a stream, while encoding or decoding.
  struct StreamState {
    std::int32_t id = 0;
    std::uint64_t size = 0, elements = 0, last = 0, span = 0;  ///< of its last packet; times in us
  };

  void put(std::uint64_t number);

  std::uint64_t begin_;
  std::size_t packets_ = 0;
  std::vector<StreamState> streams_;
  std::deque<std::uint8_t> bytes_;  ///< five numbers per packet, seven bits per byte
};

}  // namespace tactile::events
