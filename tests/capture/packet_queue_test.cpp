#include "tactile/capture/packet_queue.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "capture/made_source.hpp"
#include "tactile/events/event.hpp"

namespace tactile::capture {
namespace {

using namespace std::chrono_literals;
using Packet = PacketQueue::Packet;

/// With `count` events, in a buffer for `capacity` of them.
void fill(Packet& packet, std::size_t count, std::size_t capacity = 0) {
  packet.front().elements.events.reserve(capacity);
  packet.front().elements.events.assign(count, test::event_at(7));
}

TEST(PacketQueue, HandsPacketsOverInOrder) {
  PacketQueue queue(1 << 20);
  for (std::size_t i = 0; i < 3; ++i) {
    Packet packet = queue.take();
    fill(packet, i + 1);
    packet.front().source_index = i;
    ASSERT_TRUE(queue.push(packet, false));
    EXPECT_TRUE(packet.empty());
  }
  EXPECT_GT(queue.waiting_bytes(), 6 * sizeof(events::Event));
  for (std::size_t i = 0; i < 3; ++i) {
    Packet packet;
    ASSERT_TRUE(queue.pop(packet, 1ms));
    ASSERT_EQ(packet.size(), 1U);
    EXPECT_EQ(packet.front().source_index, i);
    EXPECT_EQ(packet.front().elements.events.size(), i + 1);
  }
  EXPECT_EQ(queue.waiting_bytes(), 0U);
}

TEST(PacketQueue, AllocatesNothingOnceItIsWarm) {
  PacketQueue queue(1 << 20);
  const events::Event* buffer = nullptr;
  for (int i = 0; i < 1000; ++i) {
    Packet packet = queue.take();
    EXPECT_TRUE(packet.front().elements.events.empty());
    fill(packet, 100);
    if (buffer == nullptr) buffer = packet.front().elements.events.data();
    EXPECT_EQ(packet.front().elements.events.data(), buffer);
    ASSERT_TRUE(queue.push(packet, false));
    ASSERT_TRUE(queue.pop(packet, 1ms));
    queue.give_back(std::move(packet));
  }
  EXPECT_EQ(queue.packets_made(), 1U);
}

TEST(PacketQueue, RefusesWhatFindsNoRoomAndLeavesItToTheCaller) {
  PacketQueue queue(100'000);
  std::size_t taken = 0;
  Packet packet = queue.take();
  for (; taken < 1000; ++taken) {
    fill(packet, 1000);
    if (!queue.push(packet, false)) break;
    EXPECT_LE(queue.waiting_bytes(), queue.limit());
    packet = queue.take();
  }
  EXPECT_EQ(taken, 100'000 / (1000 * sizeof(events::Event) + sizeof(QueuedPacket)));
  ASSERT_EQ(packet.size(), 1U);
  EXPECT_EQ(packet.front().elements.events.size(), 1000U);
  Packet first;
  ASSERT_TRUE(queue.pop(first, 1ms));
  EXPECT_TRUE(queue.push(packet, false));
}

TEST(PacketQueue, TakesAPacketLargerThanItsLimitOnlyIfNothingElseWaits) {
  PacketQueue queue(1000);
  Packet large = queue.take();
  fill(large, 1000);
  EXPECT_TRUE(queue.push(large, false));
  Packet small = queue.take();
  EXPECT_FALSE(queue.push(small, false));
  EXPECT_FALSE(small.empty());
}

TEST(PacketQueue, CutsRoomyBuffersToSizeWhereRoomGetsShort) {
  PacketQueue queue(100'000);
  Packet packet = queue.take();
  fill(packet, 2000);
  ASSERT_TRUE(queue.push(packet, false));  // a third of it
  for (int i = 0; i < 100; ++i) {
    packet = queue.take();
    fill(packet, 1, 5000);  // 80 000 bytes for 16
    ASSERT_TRUE(queue.push(packet, false)) << i;
  }
}

TEST(PacketQueue, KeepsNoMoreSpareBuffersThanItsLimit) {
  PacketQueue queue(100'000);
  std::vector<Packet> packets;
  for (int i = 0; i < 20; ++i) {
    packets.push_back(queue.take());
    fill(packets.back(), 1000);
  }
  for (Packet& packet : packets) queue.give_back(std::move(packet));
  std::size_t kept = 0;
  packets.clear();
  for (int i = 0; i < 20; ++i) {
    packets.push_back(queue.take());
    if (packets.back().front().elements.events.capacity() >= 1000) ++kept;
  }
  EXPECT_EQ(kept, 100'000 / (1000 * sizeof(events::Event) + sizeof(QueuedPacket)));
}

TEST(PacketQueue, FreesWhatABurstLeftAndNothingHasUsedSince) {
  PacketQueue queue(1 << 20);
  const auto burst = [&queue](std::size_t count) {
    std::vector<Packet> packets;
    for (std::size_t i = 0; i < count; ++i) {
      packets.push_back(queue.take());
      fill(packets.back(), 1000);
    }
    for (Packet& packet : packets) queue.give_back(std::move(packet));
  };
  const auto made_for = [&](std::size_t count) {
    const std::uint64_t before = queue.packets_made();
    burst(count);
    return queue.packets_made() - before;
  };
  burst(20);
  EXPECT_EQ(made_for(20), 0U);  // soon after it they are still there
  for (int i = 0; i < 100'000; ++i) burst(3);
  EXPECT_EQ(made_for(3), 0U);
  EXPECT_EQ(made_for(20), 17U);
}

TEST(PacketQueue, LetsThoseWaitForRoomWhoWantTo) {
  PacketQueue queue(20'000);
  std::thread source([&] {
    for (int i = 0; i < 50; ++i) {
      Packet packet = queue.take();
      fill(packet, 1000);
      EXPECT_TRUE(queue.push(packet, true));
    }
    queue.close();
  });
  int count = 0;
  Packet packet;
  while (queue.pop(packet, 10ms)) {
    if (packet.empty()) continue;
    ++count;
    EXPECT_LE(queue.waiting_bytes(), queue.limit());
    queue.give_back(std::move(packet));
    packet.clear();
  }
  source.join();
  EXPECT_EQ(count, 50);
}

TEST(PacketQueue, ClosingReleasesThoseWhoWaitAndKeepsWhatIsIn) {
  PacketQueue queue(20'000);
  Packet packet = queue.take();
  fill(packet, 1000);
  ASSERT_TRUE(queue.push(packet, false));
  std::thread source([&] {
    Packet further = queue.take();
    fill(further, 1000);
    EXPECT_FALSE(queue.push(further, true));
    EXPECT_EQ(further.size(), 1U);
  });
  queue.close();
  source.join();
  EXPECT_TRUE(queue.pop(packet, 1ms));
  EXPECT_EQ(packet.size(), 1U);
  Packet none;
  EXPECT_FALSE(queue.pop(none, 1ms));
  EXPECT_TRUE(none.empty());
  queue.open();
  EXPECT_TRUE(queue.push(packet, false));
}

TEST(PacketQueue, DistinguishesSilenceFromTheEnd) {
  PacketQueue queue(1000);
  Packet packet;
  EXPECT_TRUE(queue.pop(packet, 1ms));
  EXPECT_TRUE(packet.empty());
}

}  // namespace
}  // namespace tactile::capture
