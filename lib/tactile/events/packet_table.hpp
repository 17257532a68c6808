#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "tactile/events/packet_compression.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// The data table of a recording in the making. A packet takes a few bytes, for it is kept as what tells it from the one before
/// it of its stream: an hour of packets of 1 ms some 25 MB. They never move, so that memory does not double from time to time.
class PacketTable {
 public:
  /// @param begin  where the first packet's header stands in the file [B]
  explicit PacketTable(std::uint64_t begin = 0) : begin_(begin) {}

  /// The next packet of the file. It begins where the one before it ends: its `payload_offset` is not looked at.
  void add(const PacketRecord& packet);

  std::size_t packets() const { return packets_; }
  std::size_t held_bytes() const { return bytes_.size(); }  ///< of memory, for the packets

  /// As the file's FTAB contents, with their size prefix.
  std::uint64_t content_size() const;          ///< [B]
  void write_contents(const ByteSink&) const;  ///< in pieces of 64 KiB at most. There may be up to 40 million packets

 private:
  /// What is known of a stream on the way, forwards as backwards.
  struct StreamState {
    std::int32_t id = 0;
    std::uint64_t size = 0, elements = 0, last = 0, span = 0;  ///< of its packet before; the times in us
  };

  void put(std::uint64_t number);

  std::uint64_t begin_;
  std::size_t packets_ = 0;
  std::vector<StreamState> streams_;
  std::deque<std::uint8_t> bytes_;  ///< five numbers a packet, seven bits a byte
};

}  // namespace tactile
