// Packets as other writers make them, damaged ones, and those made to do harm: each is met as the reader promises.
#include <gtest/gtest.h>

#include <limits>

#include "events/aedat4_bytes.hpp"
#include "events/damaged_recording.hpp"
#include "events/recording_contents.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::append;
using test::DamagedRecording;
using test::event;
using test::event_payload;
using test::file_start;
using test::one_camera;
using test::packet;
using test::put;
using test::row_of_events;
using test::ThreePackets;
using test::with_table;
using test::xml_of;

// --- packet headers
// ------------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, SkipsPacketsOfSizeZero) {
  const auto a = row_of_events(100, 3);
  const auto b = row_of_events(200, 4);
  const std::string bytes =
      file_start(0, one_camera) + packet(0, "") + packet(0, event_payload(a)) + packet(0, "") + packet(0, event_payload(b));
  RecordingReader recording = reader_of(bytes);
  EXPECT_EQ(recording.problems().empty_packets, 2U);
  EXPECT_EQ(recording.problems().truncated_bytes, 0U);
  EXPECT_EQ(recording.problems().broken_packets, 0U);
  ASSERT_EQ(recording.packets().size(), 2U);
  EXPECT_EQ(test::contents_of(recording).events.size(), 7U);

  RecordingReader compressed = reader_of(file_start(1, one_camera) + packet(0, "") + packet(0, test::lz4(event_payload(a))));
  EXPECT_EQ(compressed.problems().empty_packets, 1U);
  EXPECT_EQ(test::contents_of(compressed).events, a);
}

TEST_F(DamagedRecording, StopsAtANegativeOrHugeSize) {
  const auto events = row_of_events(100, 3);
  const std::string sound = file_start(0, one_camera) + packet(0, event_payload(events));
  for (const std::int32_t size :
       {-1, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max(), 1'000'000}) {
    std::string bytes = sound;
    append(bytes, std::int32_t{0});
    append(bytes, size);
    bytes += std::string(500, 'x');
    RecordingReader recording = reader_of(bytes);
    EXPECT_EQ(recording.packets().size(), 1U) << size;
    EXPECT_EQ(recording.problems().truncated_bytes, 508U) << size;
    EXPECT_EQ(test::contents_of(recording).events, events);
  }
}

TEST_F(DamagedRecording, SkipsAndCountsStreamsThatAreNotDeclared) {
  for (const int compression : {0, 1, 3}) {
    const auto stored = [&](const std::vector<Event>& events) {
      const std::string plain = event_payload(events);
      return compression == 0 ? plain : compression == 1 ? test::lz4(plain) : test::zstd(plain);
    };
    const auto events = row_of_events(100, 3);
    RecordingReader recording = reader_of(file_start(compression, one_camera) + packet(7, stored(row_of_events(0, 9))) +
                                          packet(0, stored(events)) + packet(-8, stored(row_of_events(0, 9))));
    EXPECT_EQ(recording.problems().undeclared_packets, 2U);
    EXPECT_EQ(recording.problems().truncated_bytes, 0U);
    ASSERT_EQ(recording.packets().size(), 1U);
    EXPECT_EQ(test::contents_of(recording).events, events);
  }
}

TEST_F(DamagedRecording, StopsWhereAnUndeclaredStreamHoldsWhatNoPacketHolds) {
  for (const int compression : {0, 1, 3}) {
    const std::string start = file_start(compression, one_camera);
    RecordingReader recording = reader_of(start + packet(7, std::string(100, 'x')) + std::string(50, 'y'));
    EXPECT_EQ(recording.problems().undeclared_packets, 0U);
    EXPECT_EQ(recording.problems().truncated_bytes, 158U);
  }
}

TEST_F(DamagedRecording, SkipsPacketsOfAnotherTypeThanTheirStreams) {
  std::string imu = event_payload({});
  imu.replace(8, 4, "IMUS");
  const auto events = row_of_events(100, 3);
  const ThreePackets three;
  RecordingReader recording = reader_of(file_start(0, one_camera) + packet(0, imu) + packet(0, event_payload(events)));
  EXPECT_EQ(recording.problems().mismatched_packets, 1U);
  EXPECT_EQ(recording.problems().broken_packets, 0U);
  EXPECT_EQ(test::contents_of(recording).events, events);
  EXPECT_EQ(recording.problems().mismatched_packets, 1U) << "reading again must not count again";
}

TEST_F(DamagedRecording, IsRefusedIfItsEventsAreLossyTimeBins) {
  // Of jAER: letters, version, number of bins; then each bin's time, its number of records and x, y, polarity and count of each.
  std::string bins = "LBEV";
  append(bins, std::uint16_t{1});
  append(bins, std::uint32_t{1});
  append(bins, std::uint64_t{1'024});
  append(bins, std::uint32_t{1});
  append(bins, std::uint16_t{5});
  append(bins, std::uint16_t{6});
  append(bins, std::uint8_t{1});
  append(bins, std::uint16_t{3});
  for (const int compression : {0, 1, 3}) {
    const auto stored = [&](const std::string& content) {
      return compression == 0 ? content : compression == 1 ? test::lz4(content) : test::zstd(content);
    };
    EXPECT_NE(error_of(file_start(compression, one_camera) + packet(0, stored(event_payload(row_of_events(100, 3)))) +
                       packet(0, stored(bins)))
                  .find("has jAER's lossy time bins (LBEV), which count events instead of listing them; expected events (EVTS): "
                        "record again, with lossy time bins off in jAER"),
              std::string::npos)
        << compression;
  }
  std::string identified = event_payload(row_of_events(100, 3));
  identified.replace(8, 4, "LBEV");
  EXPECT_NE(error_of(file_start(0, one_camera) + packet(0, event_payload(row_of_events(100, 3))) + packet(0, identified))
                .find("has jAER's lossy time bins (LBEV)"),
            std::string::npos);
}

// --- packet contents
// -----------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, TakesAnEmptyEventPacketForEmpty) {
  std::string without_field = event_payload({}).substr(0, 28);  // the vtable ends before `elements`
  put(without_field, 14, std::uint16_t{4});
  put(without_field, 16, std::uint16_t{4});
  const auto events = row_of_events(500, 3);
  RecordingReader recording = reader_of(file_start(0, one_camera) + packet(0, event_payload({})) +
                                        packet(0, test::prefixed(without_field)) + packet(0, event_payload(events)));
  EXPECT_EQ(recording.problems().broken_packets, 0U);
  ASSERT_EQ(recording.packets().size(), 3U);
  EXPECT_EQ(recording.packets()[0].elements, 0);
  EXPECT_EQ(recording.packets()[1].elements, 0);
  EXPECT_TRUE(recording.read_events(recording.packets()[1]).empty());
  EXPECT_EQ(test::contents_of(recording).events, events);

  // Its times are 0 and must not take part in a search by time.
  std::size_t found = 0;
  for_events_between(recording, 0, camera_time(-10), camera_time(10), [&](auto span) { found += span.size(); });
  EXPECT_EQ(found, 0U);
}

TEST_F(DamagedRecording, RefusesContentsThatWouldTakeMoreThanTheLimit) {
  const auto events = row_of_events(100, 3);
  const std::string zeros(std::size_t{300} << 20, '\0');
  std::string claims_much = test::zstd(event_payload(events));
  // Magic, a descriptor for "single segment, 8 bytes of content size", 2^40, one raw block.
  claims_much = std::string("\x28\xB5\x2F\xFD\xE0", 5);
  append(claims_much, std::uint64_t{1} << 40);
  claims_much += std::string(
      "\x19\x00\x00"
      "abc",
      6);
  std::string long_by_prefix = event_payload(events);
  put(long_by_prefix, 0, std::uint32_t{0x7fffffff});
  long_by_prefix += std::string(std::size_t{1} << 20, '\0');

  RecordingReader lz4 = reader_of(file_start(1, one_camera) + packet(0, test::lz4(zeros)) + packet(0, test::lz4(long_by_prefix)) +
                                  packet(0, test::lz4(event_payload(events))));
  EXPECT_EQ(lz4.problems().broken_packets, 2U);
  EXPECT_EQ(test::contents_of(lz4).events, events);
  RecordingReader zstd = reader_of(
      file_start(3, one_camera) + packet(0, test::zstd(zeros)) + packet(0, test::zstd_without_size(zeros)) +
      packet(0, claims_much) + packet(0, test::zstd_without_size(long_by_prefix)) + packet(0, test::zstd(event_payload(events))));
  EXPECT_EQ(zstd.problems().broken_packets, 4U);
  EXPECT_EQ(test::contents_of(zstd).events, events);
}

TEST_F(DamagedRecording, RefusesVectorsAndOffsetsThatLie) {
  const auto events = row_of_events(100, 30);
  const std::string sound = event_payload(events);
  std::vector<std::string> lies;
  for (const std::uint32_t length : {31U, 0x0fffffffU, 0x10000000U, 0x7fffffffU, 0xffffffffU}) {
    lies.push_back(sound);
    put(lies.back(), 28, length);
  }
  for (const std::size_t at : {std::size_t{0}, std::size_t{4}, std::size_t{14}, std::size_t{20}, std::size_t{24}}) {
    lies.push_back(sound);
    put(lies.back(), at, std::uint32_t{0x7ffffff0});
  }
  lies.push_back(sound.substr(0, sound.size() - 16));
  lies.push_back(sound.substr(0, 11));
  lies.push_back(std::string(100, '\xff'));
  std::string bytes = file_start(0, one_camera);
  for (const std::string& lie : lies) bytes += packet(0, lie);
  bytes += packet(0, sound);
  RecordingReader recording = reader_of(bytes);
  EXPECT_EQ(recording.packets().size(), lies.size() + 1);
  EXPECT_EQ(recording.problems().broken_packets, lies.size());
  EXPECT_EQ(test::contents_of(recording).events, events);
  EXPECT_EQ(recording.problems().broken_packets, lies.size()) << "reading again must not count again";
}

TEST_F(DamagedRecording, SkipsPacketsThatDoNotDecompress) {
  const auto events = row_of_events(100, 300);
  const std::string good = test::lz4(event_payload(events));
  std::string cut = good.substr(0, good.size() - 6);
  std::string cut_in_header = good.substr(0, 5);
  std::string followed = good + "more";
  std::string raw = event_payload(events);
  std::string checked = test::lz4(event_payload(events), {.checksums = true});
  checked[checked.size() / 2] = static_cast<char>(checked[checked.size() / 2] ^ 0x55);
  std::string bytes = file_start(1, one_camera);
  for (const std::string& bad : {cut, cut_in_header, followed, raw, checked, test::lz4("")}) bytes += packet(0, bad);
  RecordingReader recording = reader_of(bytes + packet(0, good));
  EXPECT_EQ(recording.problems().broken_packets, 6U);
  EXPECT_EQ(test::contents_of(recording).events, events);

  const std::string frame = test::zstd(event_payload(events));
  const std::string stream = test::zstd_without_size(event_payload(events));
  RecordingReader zstd = reader_of(file_start(3, one_camera) + packet(0, frame.substr(0, frame.size() - 3)) +
                                   packet(0, stream.substr(0, stream.size() - 3)) + packet(0, stream + "more") +
                                   packet(0, event_payload(events)) + packet(0, frame));
  EXPECT_EQ(zstd.problems().broken_packets, 4U);
  EXPECT_EQ(test::contents_of(zstd).events, events);
}

TEST_F(DamagedRecording, ReadsEveryLegalKindOfFrame) {
  const auto few = row_of_events(100, 10);
  const auto many = row_of_events(1'000, 90'000);  // 1.4 MB: many blocks
  for (const auto block : {LZ4F_default, LZ4F_max64KB, LZ4F_max256KB, LZ4F_max1MB, LZ4F_max4MB}) {
    for (const auto mode : {LZ4F_blockLinked, LZ4F_blockIndependent}) {
      for (const bool checksums : {false, true}) {
        const test::Lz4Kind kind{.block = block, .mode = mode, .checksums = checksums};
        const auto read = contents_of(file_start(2, one_camera) + packet(0, test::lz4(event_payload(few), kind)) +
                                      packet(0, test::lz4(event_payload(many), kind)));
        ASSERT_EQ(read.events.size(), few.size() + many.size());
        EXPECT_TRUE(std::equal(many.begin(), many.end(), read.events.begin() + 10));
      }
    }
  }
  for (const int compression : {3, 4}) {
    const auto read =
        contents_of(file_start(compression, one_camera) + packet(0, test::zstd_without_size(event_payload(few))) +
                    packet(0, test::zstd_without_size(event_payload(many))) + packet(0, test::zstd(event_payload(few))));
    ASSERT_EQ(read.events.size(), 2 * few.size() + many.size());
    EXPECT_TRUE(std::equal(many.begin(), many.end(), read.events.begin() + 10));
  }
}

TEST_F(DamagedRecording, ReadsPacketsThatCompressManyTimes) {
  const std::vector<Event> alike(50'000, event(100, 3, 4, 1));
  const std::string payload = event_payload(alike);
  const std::string stored = test::lz4(payload);
  ASSERT_GT(payload.size(), 100 * stored.size());
  EXPECT_EQ(contents_of(file_start(1, one_camera) + packet(0, stored)).events, alike);
  const std::string stream = test::zstd_without_size(payload);
  ASSERT_GT(payload.size(), 100 * stream.size());
  EXPECT_EQ(contents_of(file_start(3, one_camera) + packet(0, stream)).events, alike);
}

/// As a writer makes it that aligns to the root offset instead of the size prefix.
std::string event_payload_aligned_after_prefix(const std::vector<Event>& events) {
  std::string payload = event_payload(events);
  payload.insert(28, 4, '\0');  // the vector moves by four
  put(payload, 24, std::uint32_t{8});
  return test::prefixed(payload);
}

TEST_F(DamagedRecording, ReadsEventsAlignedToTheRootOffset) {
  const auto events = row_of_events(100, 33);
  RecordingReader recording = reader_of(file_start(0, one_camera) + packet(0, event_payload_aligned_after_prefix(events)));
  const auto read = recording.read_events(recording.packets()[0]);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(read.data()) % alignof(Event), 0U);
  EXPECT_TRUE(std::equal(read.begin(), read.end(), events.begin(), events.end()));
}

TEST_F(DamagedRecording, ReadsTablesAlignedToTheRootOffset) {
  // One sample of two fields, whose time lies 52 bytes after the start of the prefix: a multiple of 8 from the root offset on.
  std::string imu(64, '\0');
  put(imu, 4, std::uint32_t{16});
  imu.replace(8, 4, "IMUS");
  for (const auto& [at, value] : {std::pair{14, 6}, {16, 8}, {18, 4}, {36, 8}, {38, 16}, {40, 4}, {42, 12}}) {
    put(imu, static_cast<std::size_t>(at), static_cast<std::uint16_t>(value));
  }
  put(imu, 20, std::int32_t{6});
  put(imu, 24, std::uint32_t{4});
  put(imu, 28, std::uint32_t{1});
  put(imu, 32, std::uint32_t{16});
  put(imu, 48, std::int32_t{12});
  put(imu, 52, std::int64_t{1234567});
  put(imu, 60, 25.5F);
  const auto read = contents_of(file_start(0, xml_of(test::plain_node(4, "IMUS"))) + packet(4, test::prefixed(imu)));
  ASSERT_EQ(read.imu.size(), 1U);
  EXPECT_EQ(read.imu[0].t, camera_time(1234567));
  EXPECT_EQ(read.imu[0].temperature_c, 25.5F);
}

TEST_F(DamagedRecording, DropsAndCountsEventsOutsideTheSensor) {
  std::vector<Event> events{event(1, 0, 0, 0),   event(2, 639, 479, 1), event(3, 640, 0, 0),   event(4, 0, 480, 0),
                            event(5, -1, 0, 1),  event(6, 0, -1, 1),    event(7, 32767, 5, 1), event(8, 5, 5, 2),
                            event(9, 6, 6, 255), event(10, 7, 7, 0)};
  const std::string bytes =
      file_start(0, one_camera) + packet(0, event_payload(events)) + packet(0, event_payload(row_of_events(20, 2)));
  RecordingReader recording = reader_of(bytes);
  EXPECT_EQ(recording.problems().out_of_range_events, 7U);
  ASSERT_EQ(recording.packets()[0].elements, 3);
  EXPECT_EQ(recording.packets()[0].last, camera_time(10));
  const auto kept = recording.read_events(recording.packets()[0]);
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[0], events[0]);
  EXPECT_EQ(kept[1], events[1]);
  EXPECT_EQ(kept[2], events[9]);
  EXPECT_EQ(recording.problems().out_of_range_events, 7U) << "reading again must not count again";
}

TEST_F(DamagedRecording, CountsEventsOutsideTheSensorOnceWhereATableSparesTheScan) {
  const std::vector<Event> events{event(1, 0, 0, 0), event(2, 700, 1, 1), event(3, 3, 3, 7)};
  const std::string payload = event_payload(events);
  std::string bytes = file_start(0, one_camera);
  const test::TableEntry entry{.offset = static_cast<std::int64_t>(bytes.size() + 8),
                               .id = 0,
                               .size = static_cast<std::int32_t>(payload.size()),
                               .elements = 3,
                               .first = 1,
                               .last = 3};
  RecordingReader recording = reader_of(with_table(bytes + packet(0, payload), test::table_of({entry})));
  ASSERT_EQ(recording.index(), PacketIndex::table);
  EXPECT_EQ(recording.problems().out_of_range_events, 0U);
  const PacketRecord copy = recording.packets()[0];
  for (int time = 0; time < 3; ++time) EXPECT_EQ(recording.read_events(copy).size(), 1U);
  EXPECT_EQ(recording.problems().out_of_range_events, 2U);
}

TEST_F(DamagedRecording, WithoutASensorSizeDropsOnlyNegativePlaces) {
  RecordingReader recording = reader_of(file_start(0, xml_of(test::plain_node(0, "EVTS"))) +
                                        packet(0, event_payload({event(1, 32767, 32767, 1), event(2, -1, 0, 1)})));
  EXPECT_FALSE(recording.streams()[0].size.has_value());
  EXPECT_EQ(test::contents_of(recording).events.size(), 1U);
  EXPECT_EQ(recording.problems().out_of_range_events, 1U);
}

}  // namespace
}  // namespace tactile::events
