// What recordings look like after a crash: as much of them is read as the reader promises.
#include <gtest/gtest.h>

#include <limits>

#include "events/aedat4_bytes.hpp"
#include "events/damaged_recording.hpp"
#include "events/recording_contents.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::DamagedRecording;
using test::event;
using test::event_payload;
using test::file_start;
using test::layout_of;
using test::one_camera;
using test::packet;
using test::put;
using test::row_of_events;
using test::ThreePackets;
using test::vendor_bytes;
using test::with_table;

// --- cut off
// ---------------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, KeepsEveryWholePacketWhereverItIsCut) {
  for (const char* name : {"dv-none", "dv-lz4", "dv-zstd"}) {
    const std::string whole = vendor_bytes(name);
    const auto layout = layout_of(whole);
    RecordingReader original = reader_of(whole);
    for (const bool closed : {false, true}) {
      for (std::size_t cut = layout.data_begin; cut < layout.table_at; cut += 1009) {
        std::string bytes = whole.substr(0, cut);
        if (!closed) put(bytes, test::position_at, std::int64_t{-1});
        RecordingReader recording = reader_of(bytes);
        std::size_t kept = 0;
        while (kept < layout.packets.size() && layout.packets[kept].end() <= cut) ++kept;
        const std::size_t end = kept == 0 ? layout.data_begin : layout.packets[kept - 1].end();
        ASSERT_EQ(recording.packets().size(), kept) << name << " cut at " << cut;
        EXPECT_EQ(recording.index(), PacketIndex::scan);
        EXPECT_EQ(recording.problems().truncated_bytes, cut - end);
        EXPECT_EQ(recording.problems().table.empty(), !closed) << recording.problems().table;
        EXPECT_EQ(recording.problems().broken_packets, 0U);
        for (std::size_t i = 0; i < kept; ++i) {  // a scan finds the same as the table
          const PacketRecord& scanned = recording.packets()[i];
          const PacketRecord& listed = original.packets()[i];
          ASSERT_EQ(scanned.payload_offset, listed.payload_offset);
          EXPECT_EQ(scanned.payload_size, listed.payload_size);
          EXPECT_EQ(scanned.stream_id, listed.stream_id);
          EXPECT_EQ(scanned.elements, listed.elements);
          EXPECT_EQ(scanned.first, listed.first);
          EXPECT_EQ(scanned.last, listed.last);
        }
      }
    }
  }
}

TEST_F(DamagedRecording, GivesTheSameEventsWithItsTableCutOff) {
  for (const char* name : {"dv-none", "dv-lz4", "dv-lz4-high", "dv-zstd", "dv-zstd-high", "dv-events-only"}) {
    const std::string whole = vendor_bytes(name);
    std::string cut = whole.substr(0, layout_of(whole).table_at);
    put(cut, test::position_at, std::int64_t{-1});
    RecordingReader recording = reader_of(cut);
    EXPECT_EQ(recording.index(), PacketIndex::scan);
    EXPECT_TRUE(recording.problems().table.empty());
    EXPECT_EQ(recording.problems().truncated_bytes, 0U);
    EXPECT_TRUE(test::same(test::contents_of(recording), contents_of(whole))) << name;
  }
}

TEST_F(DamagedRecording, WithNoPacketIsEmptyNotRefused) {
  RecordingReader recording = reader_of(file_start(1, one_camera));
  EXPECT_TRUE(recording.packets().empty());
  EXPECT_EQ(recording.problems().truncated_bytes, 0U);
  EXPECT_EQ(recording.streams().size(), 1U);
}

TEST_F(DamagedRecording, CutInsideItsHeaderIsRefused) {
  const std::string start = file_start(1, one_camera);
  for (std::size_t length = 0; length < start.size(); ++length) {
    EXPECT_THROW(reader_of(start.substr(0, length)), Error) << length;
  }
  EXPECT_SAYS(error_of(""), "is empty");
  EXPECT_SAYS(error_of(start.substr(0, 100)), "ends inside its header");
}

TEST_F(DamagedRecording, CountsTheZerosOfAPowerCutAsCutOff) {
  const std::string sound = file_start(0, one_camera) + packet(0, event_payload(row_of_events(100, 3)));
  RecordingReader recording = reader_of(sound + std::string(4096, '\0'));
  EXPECT_EQ(recording.packets().size(), 1U);
  EXPECT_EQ(recording.problems().truncated_bytes, 4096U);
  EXPECT_EQ(recording.problems().empty_packets, 0U);
}

// --- the data table
// ----------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, FindsATableThatTheHeaderWasNotPatchedFor) {
  for (const char* name : {"dv-none", "dv-lz4", "dv-lz4-high", "dv-zstd", "dv-zstd-high"}) {
    const std::string whole = vendor_bytes(name);
    for (const std::int64_t position : {-1, -2}) {
      std::string bytes = whole;
      put(bytes, test::position_at, position);
      RecordingReader recording = reader_of(bytes);
      EXPECT_EQ(recording.index(), PacketIndex::table) << name;
      EXPECT_EQ(recording.problems().truncated_bytes, 0U);
      EXPECT_EQ(recording.problems().undeclared_packets, 0U);
      EXPECT_EQ(recording.problems().table, "");
      EXPECT_EQ(recording.packets().size(), layout_of(whole).packets.size());
      EXPECT_TRUE(test::same(test::contents_of(recording), contents_of(whole)));
    }
  }
}

TEST_F(DamagedRecording, TakesAHalfWrittenTableForCutOff) {
  std::string bytes = vendor_bytes("dv-lz4");
  const auto layout = layout_of(bytes);
  put(bytes, test::position_at, std::int64_t{-1});
  bytes.resize(layout.table_at + 100);
  RecordingReader recording = reader_of(bytes);
  EXPECT_EQ(recording.index(), PacketIndex::scan);
  EXPECT_EQ(recording.packets().size(), layout.packets.size());
  EXPECT_EQ(recording.problems().truncated_bytes, 100U);
}

TEST_F(DamagedRecording, ScansWhereTheTablesPositionIsWrong) {
  for (const char* name : {"dv-none", "dv-lz4", "dv-zstd"}) {
    const std::string whole = vendor_bytes(name);
    const auto layout = layout_of(whole);
    const auto expected = contents_of(whole);
    const auto size = static_cast<std::int64_t>(whole.size());
    const auto boundary = static_cast<std::int64_t>(layout.packets[3].at);
    const auto far = std::numeric_limits<std::int64_t>::max();
    for (const std::int64_t position : {size, size + 1, far, std::int64_t{0}, std::int64_t{100}, std::int64_t{-3}, -far, boundary,
                                        boundary + 8, boundary + 21, size - 1, size - 11}) {
      std::string bytes = whole;
      put(bytes, test::position_at, position);
      RecordingReader recording = reader_of(bytes);
      EXPECT_EQ(recording.index(), PacketIndex::scan) << position;
      EXPECT_FALSE(recording.problems().table.empty()) << position;
      EXPECT_EQ(recording.problems().truncated_bytes, 0U) << name << " " << position;
      EXPECT_TRUE(test::same(test::contents_of(recording), expected)) << name << " " << position;
    }
  }
}

TEST_F(DamagedRecording, BelievesATableThatAgrees) {
  const ThreePackets three;
  RecordingReader recording = reader_of(with_table(three.bytes, test::table_of(three.entries)));
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(recording.packets()[1].elements, 11);
  EXPECT_EQ(recording.packets()[1].first, camera_time(1000));
  EXPECT_EQ(recording.packets()[1].last, camera_time(1010));
  EXPECT_EQ(test::contents_of(recording).events, three.all);
}

TEST_F(DamagedRecording, BelievesTheTableOfAShortRecording) {
  const std::string start = file_start(0, one_camera);
  for (int count = 1; count <= 32; ++count) {
    const std::string payload = event_payload(row_of_events(0, count));
    const test::TableEntry entry{.offset = static_cast<std::int64_t>(start.size() + 8),
                                 .id = 0,
                                 .size = static_cast<std::int32_t>(payload.size()),
                                 .elements = count,
                                 .first = 0,
                                 .last = count - 1};
    RecordingReader recording = reader_of(with_table(start + packet(0, payload), test::table_of({entry})));
    EXPECT_EQ(recording.index(), PacketIndex::table) << count << " events: " << recording.problems().table;
  }
}

TEST_F(DamagedRecording, AcceptsOffsetsOfThePacketHeaders) {
  ThreePackets three;
  for (auto& entry : three.entries) entry.offset -= 8;
  RecordingReader recording = reader_of(with_table(three.bytes, test::table_of(three.entries)));
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(test::contents_of(recording).events, three.all);
}

TEST_F(DamagedRecording, AcceptsAPlainTableInACompressedFile) {
  const ThreePackets three(1);
  const std::string bytes = with_table(three.bytes, test::table_of(three.entries));
  RecordingReader recording = reader_of(bytes);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(test::contents_of(recording).events, three.all);

  std::string unpatched = bytes;
  put(unpatched, test::position_at, std::int64_t{-2});
  RecordingReader found = reader_of(unpatched);
  EXPECT_EQ(found.index(), PacketIndex::table) << found.problems().table;
  EXPECT_EQ(found.problems().truncated_bytes, 0U);
  EXPECT_EQ(test::contents_of(found).events, three.all);
}

TEST_F(DamagedRecording, ScansWhereTheTableDisagreesWithThePackets) {
  using Entries = std::vector<test::TableEntry>;
  const std::vector<std::pair<const char*, std::function<void(Entries&)>>> lies{
      {"offset", [](Entries& e) { e[1].offset += 4; }},
      {"offset far off", [](Entries& e) { e[1].offset = 1LL << 40; }},
      {"negative offset", [](Entries& e) { e[1].offset = -16; }},
      {"stream", [](Entries& e) { e[1].id = 5; }},
      {"size", [](Entries& e) { e[2].size -= 1; }},
      {"negative size", [](Entries& e) { e[2].size = -5; }},
      {"one missing", [](Entries& e) { e.erase(e.begin() + 1); }},
      {"last missing", [](Entries& e) { e.pop_back(); }},
      {"one too many", [](Entries& e) { e.push_back(e.back()); }},
      {"order", [](Entries& e) { std::swap(e[0], e[1]); }},
      {"more elements than fit", [](Entries& e) { e[0].elements = 1LL << 60; }},
      {"negative elements", [](Entries& e) { e[0].elements = -1; }},
      {"times that fall", [](Entries& e) { std::swap(e[2].first, e[2].last); }},
      {"no entries", [](Entries& e) { e.clear(); }},
  };
  for (const auto& [what, lie] : lies) {
    ThreePackets three;
    lie(three.entries);
    RecordingReader recording = reader_of(with_table(three.bytes, test::table_of(three.entries)));
    EXPECT_EQ(recording.index(), PacketIndex::scan) << what;
    EXPECT_FALSE(recording.problems().table.empty()) << what;
    EXPECT_EQ(recording.problems().truncated_bytes, 0U) << what;
    EXPECT_EQ(recording.packets().size(), 3U) << what;
    EXPECT_EQ(recording.packets()[2].elements, 12) << what;
    EXPECT_EQ(test::contents_of(recording).events, three.all) << what;
  }
}

TEST_F(DamagedRecording, ScansWhereTheTableDoesNotDecode) {
  const ThreePackets three(1);
  std::string table = test::table_of(three.entries);
  put(table, 28, std::uint32_t{1'000'000});
  std::string frame = test::lz4(test::table_of(three.entries));
  frame.resize(frame.size() - 10);
  std::string other = test::table_of(three.entries);
  other.replace(8, 4, "FTAX");
  for (const std::string& bad :
       {table, frame, test::lz4(other), test::lz4(std::string(4, '\0')), test::lz4(std::string(1 << 20, 'x'))}) {
    RecordingReader recording = reader_of(with_table(three.bytes, bad));
    EXPECT_EQ(recording.index(), PacketIndex::scan);
    EXPECT_FALSE(recording.problems().table.empty());
    EXPECT_EQ(test::contents_of(recording).events, three.all);
  }
}

TEST_F(DamagedRecording, MayHaveMoreThanAMillionPackets) {
  const std::size_t count = 1'000'100;
  const auto file = folder_ / "many.aedat4";
  {
    RecordingWriter writer(file, {event_stream_declaration({640, 480}, "DVXplorer_DXM00001")},
                           {.compression = Compression::none, .packet_events = 1});
    std::vector<Event> events(count);
    for (std::size_t i = 0; i < count; ++i) events[i] = event(static_cast<std::int64_t>(i), static_cast<int>(i % 640), 1, 1);
    writer.write_events(0, events);
    writer.close();
  }
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  ASSERT_EQ(recording.packets().size(), count);
  const auto last = recording.read_events(recording.packets()[count - 1]);
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(us_of(last[0].t), static_cast<std::int64_t>(count - 1));
}

}  // namespace
}  // namespace tactile::events
