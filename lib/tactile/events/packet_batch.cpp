#include "tactile/events/packet_batch.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "tactile/core/in_order.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile::events {
namespace {

/// The packets of a batch. At its end, threads wait for the last packet: with larger batches that happens less often.
std::size_t packets_of_batch(std::size_t threads) { return threads == 1 ? 1 : std::max<std::size_t>(8 * threads, 80); }

}  // namespace

PacketBatch::PacketBatch(Compression compression, unsigned threads)
    : compression_(compression),
      compressors_(compression == Compression::none ? 1 : std::max(1U, threads)),
      packets_(packets_of_batch(compressors_.size())) {}

void PacketBatch::add(const PacketRecord& record, PacketBuffer& content, std::size_t content_size) {
  Packet& packet = packets_[count_++];
  packet.record = record;
  packet.content_size = content_size;
  std::swap(packet.content, content);
  waiting_bytes_ += content_size;
}

void PacketBatch::write_all(const std::function<void(const PacketRecord& record, std::span<const std::byte> bytes)>& write) {
  if (count_ == 0) return;
  const bool is_compressed = compression_ != Compression::none;
  std::size_t written = 0;
  const auto write_next = [&] {
    Packet& packet = packets_[written];
    std::byte* bytes = is_compressed ? packet.stored.data() : packet.content.data();
    packet.record.payload_size = static_cast<std::uint32_t>(is_compressed ? packet.stored_size : packet.content_size);
    std::memcpy(bytes, &packet.record.stream_id, sizeof packet.record.stream_id);
    std::memcpy(bytes + sizeof packet.record.stream_id, &packet.record.payload_size, sizeof packet.record.payload_size);
    write(packet.record, {bytes, packet_header_size + packet.record.payload_size});
    waiting_bytes_ -= packet.content_size;
    // Each of many places would keep the memory of a large packet. Full packets of events have 128 KiB.
    constexpr std::size_t large = std::size_t{256} << 10;
    if (packets_.size() > 1 && packet.content.capacity() > large) {
      packet.content = PacketBuffer();
      packet.stored = PacketBuffer();
    }
    ++written;
  };
  try {
    if (is_compressed) {
      InOrder writing(packets_.size());
      parallel_for_with(std::span(compressors_), count_, [&](std::size_t i, PacketCompressor& compressor) {
        try {
          Packet& packet = packets_[i];
          const std::span<const std::byte> content(packet.content.data() + packet_header_size, packet.content_size);
          packet.stored_size = compressor.compress(compression_, content, packet.stored, packet_header_size);
          writing.later(i, write_next);
        } catch (...) {
          writing.fail();
          throw;
        }
      });
    } else {
      while (written < count_) write_next();
    }
  } catch (...) {
    const auto at = [this](std::size_t i) { return packets_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::rotate(at(0), at(written), at(count_));
    count_ -= written;
    throw;
  }
  count_ = 0;
}

}  // namespace tactile::events
