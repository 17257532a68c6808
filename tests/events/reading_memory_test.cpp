#include <gtest/gtest.h>

#include "events/aedat4_bytes.hpp"
#include "events/counted_memory.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

TEST(ReadingMemory, IsAskedForOnlyUntilTheLargestPacketWasRead) {
  const test::TemporaryFolder folder;
  for (const auto compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    const auto file = folder / (std::string(name_of(compression)) + ".aedat4");
    std::vector<Event> events;
    for (int i = 0; i < 200'000; ++i) events.push_back(test::event(i, i * 7 % 640, i * 3 % 480, i % 2));
    RecordingWriter writer(file, {event_stream_declaration({640, 480}, "A")},
                           {.compression = compression, .packet_events = 3000});
    writer.write_events(0, events);
    writer.close();
    RecordingReader recording(file);
    ASSERT_EQ(recording.index(), PacketIndex::table);
    for (const PacketRecord& packet : recording.packets()) recording.read_events(packet);
    const std::size_t before_reading = test::memory_requests;
    std::size_t read = 0;
    for (const PacketRecord& packet : recording.packets()) read += recording.read_events(packet).size();
    EXPECT_EQ(test::memory_requests - before_reading, 0U) << name_of(compression);
    EXPECT_EQ(read, events.size());
  }
}

TEST(ReadingMemory, FollowsThePacketNotTheClaims) {
  const test::TemporaryFolder folder;
  const std::string xml = test::xml_of(test::event_node(0, 640, 480, "A"));
  const std::string sound = test::event_payload({test::event(1, 2, 3, 1)});
  std::string long_by_prefix = sound;
  test::put(long_by_prefix, 0, std::uint32_t{0x7fffffff});
  std::string claims_much("\x28\xB5\x2F\xFD\xE0", 5);
  test::append(claims_much, std::uint64_t{1} << 40);
  claims_much += std::string(
      "\x19\x00\x00"
      "abc",
      6);
  const auto largest_for = [&](const std::string& bytes) {
    const auto file = test::write_bytes(folder / "claims.aedat4", bytes);
    test::largest_memory_request = 0;
    RecordingReader recording(file);
    for_all_events(recording, 0, [](auto) {});
    return test::largest_memory_request.load();
  };
  constexpr std::size_t little = 1 << 20;
  EXPECT_LT(largest_for(test::file_start(1, xml) + test::packet(0, test::lz4(long_by_prefix))), little);
  EXPECT_LT(largest_for(test::file_start(3, xml) + test::packet(0, test::zstd(long_by_prefix))), little);
  EXPECT_LT(largest_for(test::file_start(3, xml) + test::packet(0, test::zstd_without_size(long_by_prefix))), little);
  EXPECT_LT(largest_for(test::file_start(3, xml) + test::packet(0, claims_much)), little);
  EXPECT_LT(largest_for(test::file_start(0, xml) + std::string("\0\0\0\0\xff\xff\xff\x7f", 8) + sound), little)
      << "a size beyond the file";
  std::string header = test::file_start(0, xml);
  test::put(header, 14, std::uint32_t{0x7fffffff});
  try {
    largest_for(header);
    ADD_FAILURE() << "a header beyond the file";
  } catch (const std::exception&) {
    EXPECT_LT(test::largest_memory_request, little);
  }
}

}  // namespace
}  // namespace tactile::events
