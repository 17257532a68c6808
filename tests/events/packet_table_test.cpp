#include "tactile/events/packet_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "events/counted_memory.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

constexpr std::uint64_t begin = 1234;

/// The table's contents. Also checks the pieces and the announced number of bytes.
std::vector<std::byte> contents_of(const PacketTable& table) {
  std::vector<std::byte> contents;
  table.write_contents([&](std::span<const std::byte> piece) {
    EXPECT_FALSE(piece.empty());
    EXPECT_LE(piece.size(), std::size_t{64} << 10);
    contents.insert(contents.end(), piece.begin(), piece.end());
  });
  EXPECT_EQ(contents.size(), table.content_size());
  return contents;
}

std::vector<PacketRecord> decoded(std::span<const std::byte> contents) {
  PacketBuffer buffer;
  buffer.grow(contents.size(), 0);
  std::copy(contents.begin(), contents.end(), buffer.data());
  std::vector<PacketRecord> records;
  EXPECT_EQ(decode_table(buffer, contents.size(), records), Contents::whole);
  return records;
}

void expect_equal(const std::vector<PacketRecord>& got, const std::vector<PacketRecord>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    SCOPED_TRACE(i);
    ASSERT_EQ(got[i].stream_id, expected[i].stream_id);
    ASSERT_EQ(got[i].payload_offset, expected[i].payload_offset);
    ASSERT_EQ(got[i].payload_size, expected[i].payload_size);
    ASSERT_EQ(got[i].elements, expected[i].elements);
    ASSERT_EQ(got[i].first, expected[i].first);
    ASSERT_EQ(got[i].last, expected[i].last);
  }
}

PacketTable table_of(const std::vector<PacketRecord>& records) {
  PacketTable table(begin);
  for (const PacketRecord& record : records) table.add(record);
  EXPECT_EQ(table.packets(), records.size());
  return table;
}

/// Sets consecutive places.
void place(std::vector<PacketRecord>& records) {
  std::uint64_t end = begin;
  for (PacketRecord& record : records) {
    record.payload_offset = end + 8;
    end = record.payload_offset + record.payload_size;
  }
}

TEST(PacketTableContents, AreWhatWasAdded) {
  Random random(1);
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  const std::array<std::int64_t, 8> odd_times{lowest, lowest + 1, -1, 0, 1, std::int64_t{1} << 32, highest - 1, highest};
  for (std::size_t count : {0, 1, 2, 3, 4, 5, 100, 1001, 30'000}) {
    SCOPED_TRACE(count);
    std::vector<PacketRecord> records(count);
    for (PacketRecord& record : records) {
      const bool is_odd = random.below(10) == 0;
      const auto time = [&] {
        return camera_time(is_odd ? odd_times[random.below(odd_times.size())]
                                  : 1'700'000'000'000'000 + static_cast<std::int64_t>(random.below(1'000'000)));
      };
      record = {.stream_id = is_odd ? std::numeric_limits<std::int32_t>::max() : static_cast<std::int32_t>(random.below(4)),
                .payload_size = static_cast<std::uint32_t>(random.below(is_odd ? std::uint64_t{1} << 31 : 100'000)),
                .elements = is_odd ? odd_times[random.below(odd_times.size())] : static_cast<std::int64_t>(random.below(10'000)),
                .first = time(),
                .last = time()};
    }
    place(records);
    expect_equal(decoded(contents_of(table_of(records))), records);
  }
}

TEST(PacketTableContents, CompressPieceByPieceToOneSoundFrame) {
  Random random(2);
  for (const std::size_t count : {std::size_t{0}, std::size_t{3}, std::size_t{20'000}}) {
    std::vector<PacketRecord> records(count);
    std::int64_t t = 1'700'000'000'000'000;
    for (PacketRecord& record : records) {
      record = {.payload_size = static_cast<std::uint32_t>(5000 + random.below(1000)),
                .elements = static_cast<std::int64_t>(900 + random.below(200)),
                .first = camera_time(t),
                .last = camera_time(t + 990)};
      t += 1000;
    }
    place(records);
    const PacketTable table = table_of(records);
    const std::vector<std::byte> contents = contents_of(table);
    for (const Compression compression : {Compression::none, Compression::lz4, Compression::lz4_high, Compression::zstd}) {
      SCOPED_TRACE(name_of(compression));
      PacketCompressor compressor;
      std::vector<std::byte> stored;
      for (int i = 0; i < 2; ++i) {  // a frame does not affect the next one
        stored.clear();
        compressor.compress_pieces(
            compression, table.content_size(), [&](const ByteSink& sink) { table.write_contents(sink); },
            [&](std::span<const std::byte> piece) { stored.insert(stored.end(), piece.begin(), piece.end()); });
      }
      if (compression != Compression::none) {
        PacketBuffer plain;
        const Decompressed result = PacketDecompressor().decompress(compression, stored, plain, packet_limit);
        ASSERT_TRUE(result.whole);
        stored.assign(plain.data(), plain.data() + result.size);
      }
      EXPECT_EQ(stored, contents);
    }
  }
}

TEST(PacketTableMemory, IsAFewBytesAPacketAndNeverMoves) {
  PacketTable table;
  Random random(3);
  std::int64_t t = 1'700'000'000'000'000;
  test::largest_memory_request = 0;
  constexpr std::size_t count = 100'000;
  for (std::size_t i = 0; i < count; ++i) {  // events of a sensor with varying rates, and an IMU
    table.add({.stream_id = 0,
               .payload_size = static_cast<std::uint32_t>(8000 + random.below(4000)),
               .elements = static_cast<std::int64_t>(1500 + random.below(1000)),
               .first = camera_time(t + static_cast<std::int64_t>(random.below(10))),
               .last = camera_time(t + 990 + static_cast<std::int64_t>(random.below(10)))});
    table.add({.stream_id = 1, .payload_size = 120, .elements = 1, .first = camera_time(t), .last = camera_time(t)});
    t += 1000;
  }
  EXPECT_LE(table.held_bytes(), 8 * 2 * count);
  EXPECT_LE(test::largest_memory_request, std::size_t{64} << 10);
}

TEST(PacketTableMemory, OfAClosingRecordingFollowsAPiece) {
  const test::TemporaryFolder folder;
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    SCOPED_TRACE(name_of(compression));
    const auto file = folder / (std::string(name_of(compression)) + ".aedat4");
    constexpr std::int64_t packets = 20'000;
    RecordingWriter writer(file, {event_stream_declaration({640, 480}, "A")},
                           {.compression = compression, .packet_span = microseconds{1}});
    test::largest_memory_request = 0;
    for (std::int64_t t = 0; t < packets; ++t)
      writer.write_events(0, std::array{Event{.t = camera_time(t), .x = 1, .y = 2, .on = 1}});
    writer.close();
    EXPECT_LE(test::largest_memory_request, std::size_t{256} << 10);
    const std::vector<WrittenStream> written = writer.written();
    ASSERT_EQ(written.size(), 1U);
    EXPECT_EQ(written[0].packets, 20'000U);
    EXPECT_EQ(written[0].elements, 20'000U);
    EXPECT_EQ(written[0].first, camera_time(0));
    EXPECT_EQ(written[0].last, camera_time(packets - 1));
    const RecordingReader recording(file);
    EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
    EXPECT_EQ(recording.packets().size(), 20'000U);
  }
}

}  // namespace
}  // namespace tactile::events
