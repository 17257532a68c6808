#include "tactile/events/packet_batch.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile::events {
namespace {

/// A packet whose contents are its number, many times.
void add_numbered(PacketBatch& batch, int number) {
  constexpr std::size_t size = 5000;
  PacketBuffer content;
  content.grow(packet_header_size + size, 0);
  std::memset(content.data() + packet_header_size, number, size);
  batch.add({.stream_id = number, .elements = 1}, content, size);
}

std::vector<int> written_by(PacketBatch& batch, int refused) {
  std::vector<int> written;
  batch.write_all([&](const PacketRecord& record, std::span<const std::byte> bytes) {
    if (record.stream_id == refused) throw Error("the disk is full");
    std::int32_t in_header = 0;
    std::memcpy(&in_header, bytes.data(), sizeof in_header);
    EXPECT_EQ(in_header, record.stream_id);
    EXPECT_EQ(bytes.size(), packet_header_size + record.payload_size);
    written.push_back(record.stream_id);
  });
  return written;
}

TEST(PacketBatch, KeepsTheRefusedPacketAndTheLaterOnesInTheirOrder) {
  for (const Compression compression : {Compression::lz4, Compression::zstd}) {
    for (const unsigned threads : {2U, 3U}) {
      PacketBatch batch(compression, threads);
      int packets = 0;
      for (; !batch.is_full(); ++packets) add_numbered(batch, packets);
      EXPECT_GE(packets, 16);
      EXPECT_THROW(written_by(batch, 5), Error);
      EXPECT_THROW(written_by(batch, 9), Error);
      EXPECT_FALSE(batch.is_full());
      for (int i = packets; i < packets + 9; ++i) add_numbered(batch, i);  // in the places of 0 to 8
      EXPECT_TRUE(batch.is_full());
      std::vector<int> left(static_cast<std::size_t>(packets));
      std::iota(left.begin(), left.end(), 9);
      EXPECT_EQ(written_by(batch, -1), left) << threads << " threads";
      EXPECT_EQ(written_by(batch, -1), std::vector<int>{});
    }
  }
}

}  // namespace
}  // namespace tactile::events
