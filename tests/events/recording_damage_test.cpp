// What recordings look like after a crash, in other writers' hands, or made to do harm: each is met as the reader promises.
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "events/aedat4_bytes.hpp"
#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::append;
using test::event;
using test::event_node;
using test::event_payload;
using test::file_start;
using test::get;
using test::layout_of;
using test::packet;
using test::put;
using test::with_table;
using test::xml_of;

std::string vendor_bytes(const std::string& name) {
  return test::bytes_of(std::filesystem::path(test::data_folder) / "aedat4" / (name + ".aedat4"));
}

/// A recording from bytes, in a folder of its own.
class DamagedRecording : public testing::Test {
 protected:
  RecordingReader reader_of(const std::string& bytes) {
    return RecordingReader(test::write_bytes(folder_ / ("recording" + std::to_string(++made_) + ".aedat4"), bytes));
  }
  test::RecordingContents contents_of(const std::string& bytes) {
    RecordingReader recording = reader_of(bytes);
    return test::contents_of(recording);
  }
  std::string error_of(const std::string& bytes) {
    try {
      reader_of(bytes);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  test::TemporaryFolder folder_;
  int made_ = 0;
};

#define EXPECT_SAYS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

const std::string one_camera = xml_of(event_node(0, 640, 480, "DVXplorer_DXM00001"));

/// n events, one a microsecond from t on, at places that differ.
std::vector<Event> row_of_events(std::int64_t t, int n) {
  std::vector<Event> events;
  for (int i = 0; i < n; ++i) events.push_back(event(t + i, (7 * i) % 640, (5 * i) % 480, i % 2));
  return events;
}

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

/// Three packets of one camera, and the entries that a sound table has for them.
struct ThreePackets {
  explicit ThreePackets(int compression = 0) {
    bytes = file_start(compression, one_camera);
    for (int i = 0; i < 3; ++i) {
      const auto events = row_of_events(1000 * i, 10 + i);
      const std::string payload = compression == 1 ? test::lz4(event_payload(events)) : event_payload(events);
      const auto offset = static_cast<std::int64_t>(bytes.size() + 8);
      entries.push_back({.offset = offset,
                         .id = 0,
                         .size = static_cast<std::int32_t>(payload.size()),
                         .elements = 10 + i,
                         .first = 1000 * i,
                         .last = 1000 * i + 9 + i});
      bytes += packet(0, payload);
      all.insert(all.end(), events.begin(), events.end());
    }
  }
  std::string bytes;
  std::vector<test::TableEntry> entries;
  std::vector<Event> all;
};

TEST_F(DamagedRecording, BelievesATableThatAgrees) {
  const ThreePackets three;
  RecordingReader recording = reader_of(with_table(three.bytes, test::table_of(three.entries)));
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(recording.packets()[1].elements, 11);
  EXPECT_EQ(recording.packets()[1].first, camera_time(1000));
  EXPECT_EQ(recording.packets()[1].last, camera_time(1010));
  EXPECT_EQ(test::contents_of(recording).events, three.all);
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
std::string event_payload_aligned_behind_prefix(const std::vector<Event>& events) {
  std::string payload = event_payload(events);
  payload.insert(28, 4, '\0');  // the vector moves by four
  put(payload, 24, std::uint32_t{8});
  return test::prefixed(payload);
}

TEST_F(DamagedRecording, ReadsEventsAlignedToTheRootOffset) {
  const auto events = row_of_events(100, 33);
  RecordingReader recording = reader_of(file_start(0, one_camera) + packet(0, event_payload_aligned_behind_prefix(events)));
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

// --- time
// --------------------------------------------------------------------------------------------------------------------------

constexpr std::int64_t wrap = std::int64_t{1} << 32;

/// The packets of `all`, with a table or without.
std::string recording_of(const std::vector<std::vector<Event>>& all, bool table) {
  std::string bytes = file_start(0, one_camera);
  std::vector<test::TableEntry> entries;
  for (const auto& events : all) {
    const std::string payload = event_payload(events);
    entries.push_back({.offset = static_cast<std::int64_t>(bytes.size() + 8),
                       .id = 0,
                       .size = static_cast<std::int32_t>(payload.size()),
                       .elements = static_cast<std::int64_t>(events.size()),
                       .first = us_of(events.front().t),
                       .last = us_of(events.back().t)});
    bytes += packet(0, payload);
  }
  return table ? with_table(bytes, test::table_of(entries)) : bytes;
}

TEST_F(DamagedRecording, PutsRightTimesThatWentBackBy2To32) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const bool table : {false, true}) {
    // What was recorded in two hours: 32 bits of microseconds with a sign wrap after 2147 s and after 6442 s.
    const std::vector<std::int64_t> wraps{0, 0, 1, 1, 1, 2};
    std::vector<std::int64_t> truth;
    for (const std::int64_t s : {0, 2000, 3000, 4500, 6000, 7000}) truth.push_back(base + s * 1'000'000);
    std::vector<std::vector<Event>> packets;
    for (std::size_t i = 0; i < truth.size(); ++i) packets.push_back(row_of_events(truth[i] - wraps[i] * wrap, 5));
    RecordingReader recording = reader_of(recording_of(packets, table));
    EXPECT_EQ(recording.index(), table ? PacketIndex::table : PacketIndex::scan) << recording.problems().table;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(us_of(recording.packets()[i].first), truth[i]) << i;
      EXPECT_EQ(us_of(recording.packets()[i].last), truth[i] + 4) << i;
      for (int time = 0; time < 2; ++time) {
        const auto events = recording.read_events(recording.packets()[i]);
        EXPECT_EQ(us_of(events.front().t), truth[i]) << i;
        EXPECT_EQ(us_of(events.back().t), truth[i] + 4) << i;
      }
    }
    EXPECT_EQ(recording.problems().unwrapped_packets, 4U);
    std::size_t found = 0;
    for_events_between(recording, 0, camera_time(truth[4] + 1), camera_time(truth[5] + 2),
                       [&](auto events) { found += events.size(); });
    EXPECT_EQ(found, 6U);
  }
}

TEST_F(DamagedRecording, PutsRightAWrapInsideAPacket) {
  for (const bool table : {false, true}) {
    const std::vector<Event> first{event(1000, 1, 1, 1), event(1001, 2, 2, 1), event(1002 - wrap, 3, 3, 0),
                                   event(1003 - wrap, 4, 4, 0)};
    RecordingReader recording = reader_of(recording_of({first, row_of_events(2000 - wrap, 3)}, table));
    EXPECT_EQ(recording.index(), PacketIndex::scan) << "its table has an entry that ends before it begins";
    const auto all = test::contents_of(recording).events;
    std::vector<std::int64_t> times;
    for (const Event& e : all) times.push_back(us_of(e.t));
    EXPECT_EQ(times, (std::vector<std::int64_t>{1000, 1001, 1002, 1003, 2000, 2001, 2002}));
    EXPECT_EQ(recording.problems().unwrapped_packets, 2U);
  }
}

TEST_F(DamagedRecording, TakesOneDamagedTimeForNoOverflow) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const std::int64_t off : {wrap, -wrap, wrap - 1'000'000'000, 1'000'000'000 - wrap}) {
    for (const bool table : {false, true}) {
      for (const std::size_t hit : {std::size_t{0}, std::size_t{4}, std::size_t{9}}) {
        std::vector<std::vector<Event>> packets;
        for (int p = 0; p < 5; ++p) packets.push_back(row_of_events(base + 1000 * p, 10));
        std::vector<std::vector<Event>> expected = packets;
        packets[2][hit].t += microseconds{off};
        RecordingReader recording = reader_of(recording_of(packets, table));
        for (int time = 0; time < 2; ++time) {  // read again, they are the same
          for (std::size_t p = 0; p < packets.size(); ++p) {
            const auto read = recording.read_events(recording.packets()[p]);
            ASSERT_EQ(read.size(), 10U);
            for (std::size_t i = 0; i < 10; ++i) {
              if (p == 2 && i == hit) continue;
              EXPECT_EQ(read[i].t, expected[p][i].t) << p << ", " << i << " where " << hit << " is off by " << off;
            }
            // A packet's last time that is too early may be an overflow; the next packet decides.
            if (p == 2 && !(off < 0 && hit == 9)) {
              EXPECT_EQ(us_of(read[hit].t), us_of(packets[2][hit].t)) << hit << " is off by " << off;
            }
          }
        }
        for (const std::size_t p : {0U, 1U, 3U, 4U}) {
          EXPECT_EQ(recording.packets()[p].first, expected[p].front().t) << p << " where " << hit << " is off by " << off;
          EXPECT_EQ(recording.packets()[p].last, expected[p].back().t) << p << " where " << hit << " is off by " << off;
        }
        std::size_t found = 0;
        for_events_between(recording, 0, expected[2][1].t, expected[3][5].t, [&](auto events) { found += events.size(); });
        EXPECT_GE(found, 13U) << hit << " is off by " << off;
      }
    }
  }
}

TEST_F(DamagedRecording, DoesNotTakeADamagedTimeAfterAnOverflowForAnother) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const std::int64_t off : {wrap, -wrap}) {
    for (const bool table : {false, true}) {
      std::vector<std::vector<Event>> packets, expected;
      for (int p = 0; p < 6; ++p) {
        expected.push_back(row_of_events(base + 1000 * p, 10));
        packets.push_back(row_of_events(base + 1000 * p - (p == 0 ? 0 : wrap), 10));
      }
      packets[4][3].t += microseconds{off};
      RecordingReader recording = reader_of(recording_of(packets, table));
      for (std::size_t p = 0; p < packets.size(); ++p) {
        const auto read = recording.read_events(recording.packets()[p]);
        for (std::size_t i = 0; i < 10; ++i) {
          if (p != 4 || i != 3) {
            EXPECT_EQ(read[i].t, expected[p][i].t) << p << ", " << i << " with " << off;
          }
        }
      }
    }
  }
}

TEST_F(DamagedRecording, LeavesEveryOtherStepBack) {
  const std::int64_t t = 10'000'000'000;
  for (const std::int64_t step : {std::int64_t{-1}, std::int64_t{-1'000'000}, -(wrap / 2), -wrap - 5, -2 * wrap}) {
    for (const bool table : {false, true}) {
      const std::vector<std::vector<Event>> packets{{event(t, 1, 1, 1)}, {event(t + step, 2, 2, 0)}};
      RecordingReader recording = reader_of(recording_of(packets, table));
      const auto all = test::contents_of(recording).events;
      EXPECT_EQ(us_of(all[1].t) - us_of(all[0].t), step);
      EXPECT_EQ(recording.problems().unwrapped_packets, 0U);
    }
  }
  // The two corrected ones lie just inside.
  for (const std::int64_t step : {-(wrap / 2) - 1, -wrap}) {
    const auto all = contents_of(recording_of({{event(t, 1, 1, 1)}, {event(t + step, 2, 2, 0)}}, false)).events;
    EXPECT_EQ(us_of(all[1].t) - us_of(all[0].t), step + wrap);
  }
}

TEST_F(DamagedRecording, GivesAllEventsOfASpanThoughTheyAreOutOfOrder) {
  const std::vector<Event> mixed{event(50, 1, 1, 1), event(10, 2, 2, 1), event(30, 3, 3, 1), event(20, 4, 4, 1),
                                 event(40, 5, 5, 1)};
  RecordingReader recording = reader_of(recording_of({mixed}, false));
  EXPECT_EQ(recording.packets()[0].first, camera_time(10));
  EXPECT_EQ(recording.packets()[0].last, camera_time(50));
  std::vector<int> places;
  for_events_between(recording, 0, camera_time(20), camera_time(50), [&](auto events) {
    for (const Event& e : events) places.push_back(e.x);
  });
  EXPECT_EQ(places, (std::vector<int>{3, 4, 5}));
}

TEST_F(DamagedRecording, LeavesATimestampResetForOthersToJudge) {
  std::string trigger(56, '\0');  // one TIMESTAMP_RESET: its type is the default and left out
  put(trigger, 4, std::uint32_t{16});
  trigger.replace(8, 4, "TRIG");
  for (const auto& [at, value] : {std::pair{14, 6}, {16, 8}, {18, 4}, {36, 6}, {38, 12}, {40, 4}}) {
    put(trigger, static_cast<std::size_t>(at), static_cast<std::uint16_t>(value));
  }
  put(trigger, 20, std::int32_t{6});
  put(trigger, 24, std::uint32_t{4});
  put(trigger, 28, std::uint32_t{1});
  put(trigger, 32, std::uint32_t{12});
  put(trigger, 44, std::int32_t{8});
  put(trigger, 48, std::int64_t{5'000'000});
  const auto read = contents_of(file_start(0, xml_of(event_node(0, 640, 480, "A") + test::plain_node(3, "TRIG"))) +
                                packet(0, event_payload(row_of_events(5'000'000, 2))) + packet(3, test::prefixed(trigger)) +
                                packet(0, event_payload(row_of_events(0, 2))));
  ASSERT_EQ(read.triggers.size(), 1U);
  EXPECT_EQ(read.triggers[0].type, 0);
  EXPECT_EQ(read.triggers[0].t, camera_time(5'000'000));
  ASSERT_EQ(read.events.size(), 4U);
  EXPECT_EQ(read.events[1].t, camera_time(5'000'001));
  EXPECT_EQ(read.events[2].t, camera_time(0));
}

TEST_F(DamagedRecording, HoldsTimesUpToTheEndsOfInt64) {
  constexpr auto low = std::numeric_limits<std::int64_t>::min();
  constexpr auto high = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::vector<Event>> packets{{event(low, 1, 1, 1), event(low + 1, 2, 2, 1)},
                                                {event(-1, 3, 3, 1), event(0, 4, 4, 1)},
                                                {event(high - 1, 5, 5, 1), event(high, 6, 6, 1)},
                                                {event(low, 7, 7, 1)}};
  for (const bool table : {false, true}) {
    RecordingReader recording = reader_of(recording_of(packets, table));
    const auto all = test::contents_of(recording).events;
    ASSERT_EQ(all.size(), 7U);
    EXPECT_EQ(us_of(all[0].t), low);
    EXPECT_EQ(us_of(all[5].t), high);
    EXPECT_EQ(us_of(all[6].t), low);
    EXPECT_EQ(recording.problems().unwrapped_packets, 0U);
    std::vector<int> places;
    for_events_between(recording, 0, CameraTime::min(), CameraTime::max(), [&](auto events) {
      for (const Event& e : events) places.push_back(e.x);
    });
    EXPECT_EQ(places, (std::vector<int>{1, 2, 3, 4, 5, 7})) << "the end is left out";
  }
}

// --- other writers, other files
// --------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, WithoutADeclaredStreamIsRefused) {
  // As aestream writes it: outInfo empty, no identifiers, a table of one entry at byte 0.
  const std::string start = file_start(
      0, "<dv version=\"4.0\">\n    <node name=\"outInfo\" path=\"/mainloop/Recorder/outInfo/\">\n    </node>\n</dv>\n",
      std::string(4, '\0'));
  std::string payload = event_payload(row_of_events(0, 4));
  payload.replace(8, 4, std::string(4, '\0'));
  std::string table = test::table_of({{.offset = 0, .id = 0, .size = 4, .elements = 4, .first = 0, .last = 3}});
  table.replace(8, 4, std::string(4, '\0'));
  EXPECT_SAYS(error_of(with_table(start + packet(0, payload), table)), "declares no stream; expected");
  EXPECT_SAYS(error_of(file_start(0, "<dv version=\"2.0\"></dv>")), "declares no stream");
  EXPECT_SAYS(error_of(file_start(0, "")), "declares no stream");
  EXPECT_SAYS(error_of(file_start(0, "<dv")), "does not parse");
}

TEST_F(DamagedRecording, WithABadHeaderIsRefused) {
  EXPECT_SAYS(error_of(file_start(0, one_camera, "ABCD")), "IOHE");
  EXPECT_SAYS(error_of(file_start(5, one_camera)), "compression 5");
  EXPECT_SAYS(error_of(file_start(-1, one_camera)), "compression -1");
  std::string bytes = file_start(0, one_camera);
  put(bytes, 14 + 48, std::uint32_t{0x7fffffff});
  EXPECT_SAYS(error_of(bytes), "does not decode");
  bytes = file_start(0, one_camera) + std::string(std::size_t{20} << 20, '\0');
  put(bytes, 14, std::uint32_t{18 << 20});
  EXPECT_SAYS(error_of(bytes), "claims a header of");
}

TEST_F(DamagedRecording, MayLackTheOutputsNameAndTheTable) {
  // As faery writes it.
  const auto events = row_of_events(100, 50);
  const std::string node =
      "<node name=\"0\" path=\"/mainloop/Recorder/outInfo/0/\"><attr key=\"typeIdentifier\" type=\"string\">EVTS</attr>"
      "<node name=\"info\"><attr key=\"sizeX\" type=\"int\">640</attr><attr key=\"sizeY\" type=\"int\">480</attr></node></node>";
  RecordingReader recording = reader_of(file_start(3, xml_of(node)) + packet(0, test::zstd_without_size(event_payload(events))));
  EXPECT_EQ(recording.stream(0).name, "");
  EXPECT_EQ(recording.stream(0).source, "");
  EXPECT_EQ(recording.problems().table, "");
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST_F(DamagedRecording, AcceptsEveryFormOfInfoThatIsKnown) {
  const std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n<dv version=\"7.3\"><node name=\"somethingElse\"><attr "
      "key=\"a\" "
      "type=\"int\">1</attr></node><node name=\"outInfo\"><attr key=\"b\" type=\"string\">c</attr>" +
      test::plain_node(9, "BBOX") + "<node name=\"extra\"><attr key=\"typeIdentifier\" type=\"string\">EVTS</attr></node>" +
      "<node name=\"12\"></node>" + event_node(3, 640, 480, "DVXplorer_DXM00001") + "</node></dv>";
  std::string box = event_payload({});
  box.replace(8, 4, "BBOX");
  const auto events = row_of_events(5, 3);
  RecordingReader recording = reader_of(file_start(0, xml) + packet(9, box) + packet(3, event_payload(events)));
  ASSERT_EQ(recording.streams().size(), 2U);
  EXPECT_EQ(recording.streams()[0].type, StreamType::other);
  EXPECT_EQ(recording.streams()[0].type_identifier, "BBOX");
  EXPECT_EQ(event_stream(recording).id, 3);
  EXPECT_EQ(recording.packets().size(), 2U);
  EXPECT_EQ(recording.problems().undeclared_packets, 0U);
  EXPECT_EQ(recording.problems().mismatched_packets, 0U);
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST_F(DamagedRecording, KeepsFurtherAttributesOfAStream) {
  std::string node = event_node(0, 640, 480, "A");
  node.insert(node.find("<attr key=\"source\""), "<attr key=\"tsOffset\" type=\"long\">1605507430438338</attr>");
  RecordingReader recording = reader_of(file_start(0, xml_of(node)));
  const std::vector<std::pair<std::string, std::string>> expected{{"tsOffset", "1605507430438338"}};
  EXPECT_EQ(recording.stream(0).info, expected);
}

TEST_F(DamagedRecording, NamesWhatAForeignFileIs) {
  EXPECT_SAYS(error_of("version https://git-lfs.github.com/spec/v1\noid sha256:140e\nsize 1191471\n"), "Git LFS pointer");
  EXPECT_SAYS(error_of("#!AER-DAT1.0\r\nxxxxxxxxxxxxxxxx"), "version '1.0'");
  EXPECT_SAYS(error_of("#!AER-DAT2.0\r\n# a comment\r\n"), "version '2.0'");
  EXPECT_SAYS(error_of("#!AER-DAT3.1\r\n#Format: RAW\r\n"), "version '3.1'");
  EXPECT_SAYS(error_of(std::string("\x89HDF\r\n\x1a\n", 8) + std::string(500, 'x')), "expected the line #!AER-DAT4.0");
  for (const std::string& bag :
       {std::string("#ROSBAG V2.0\n"), std::string("SQLite format 3\0", 16), std::string("\x89MCAP0\r\n")})
    EXPECT_SAYS(error_of(bag + std::string(500, 'x')),
                "is a ROS bag, not a recording; expected what 'tactile convert' makes of it");
  EXPECT_THROW(RecordingReader(folder_ / "nowhere.aedat4"), Error);
  EXPECT_THROW(RecordingReader(folder_.path()), Error);
}

// --- several cameras
// -------------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, OfTwoCamerasRequiresAChoice) {
  const auto left = row_of_events(100, 5);
  const auto right = row_of_events(101, 7);
  const std::string xml =
      xml_of(event_node(0, 640, 480, "DVXplorer_L") + event_node(4, 640, 480, "DVXplorer_R") + test::plain_node(2, "IMUS"));
  RecordingReader recording = reader_of(file_start(0, xml) + packet(4, event_payload(right)) + packet(0, event_payload(left)));
  try {
    event_stream(recording);
    FAIL() << "two event streams must not be taken for one";
  } catch (const Error& e) {
    EXPECT_SAYS(e.what(), "0 (DVXplorer_L), 4 (DVXplorer_R)");
  }
  EXPECT_EQ(event_stream(recording, "0").id, 0);
  EXPECT_EQ(event_stream(recording, "4").id, 4);
  EXPECT_EQ(event_stream(recording, "DVXplorer_L").id, 0);
  EXPECT_EQ(event_stream(recording, "DVXplorer_R").id, 4);
  EXPECT_THROW(event_stream(recording, "2"), Error) << "an IMU's";
  EXPECT_THROW(event_stream(recording, "DVXplorer"), Error);
  EXPECT_THROW(recording.stream(1), Error);
  std::size_t found = 0;
  for_all_events(recording, 4, [&](auto events) { found += events.size(); });
  EXPECT_EQ(found, 7U);
  EXPECT_THROW(recording.read_imu(recording.packets()[0]), Error);
  PacketRecord elsewhere = recording.packets()[0];
  elsewhere.payload_offset += 1;
  EXPECT_THROW(recording.read_events(elsewhere), Error);
}

TEST_F(DamagedRecording, OfTwoStreamsWithOneSourceRequiresTheId) {
  const std::string xml = xml_of(event_node(0, 640, 480, "DVXplorer_L") + event_node(1, 640, 480, "DVXplorer_L"));
  RecordingReader recording = reader_of(file_start(0, xml));
  EXPECT_THROW(event_stream(recording, "DVXplorer_L"), Error);
  EXPECT_EQ(event_stream(recording, "1").id, 1);
}

TEST_F(DamagedRecording, WithoutEventsReportsIt) {
  RecordingReader recording = reader_of(file_start(0, xml_of(test::plain_node(2, "IMUS"))));
  try {
    event_stream(recording);
    FAIL();
  } catch (const Error& e) {
    EXPECT_SAYS(e.what(), "no event stream; expected an EVTS stream");
  }
}

// --- only what is needed
// -----------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, IsReadOnlyWhereTheTimesOverlap) {
  std::string bytes = vendor_bytes("dv-lz4");
  RecordingReader sound = reader_of(bytes);
  // Break every packet but the fifth event packet: whoever reads one more, notices.
  const PacketRecord chosen = sound.packets()[4];
  ASSERT_EQ(chosen.stream_id, 0);
  for (const PacketRecord& other : sound.packets()) {
    if (other.payload_offset != chosen.payload_offset) bytes.replace(other.payload_offset, 16, 16, 'x');
  }
  RecordingReader recording = reader_of(bytes);
  ASSERT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  std::vector<Event> read;
  const CameraTime begin = sound.packets()[3].last + 1us;
  const CameraTime end = sound.packets()[5].first;
  for_events_between(recording, 0, begin, end, [&](auto events) { read.insert(read.end(), events.begin(), events.end()); });
  EXPECT_EQ(recording.problems().broken_packets, 0U);
  const auto expected = sound.read_events(chosen);
  std::vector<Event> inside;
  std::copy_if(expected.begin(), expected.end(), std::back_inserter(inside),
               [&](const Event& e) { return e.t >= begin && e.t < end; });
  EXPECT_FALSE(inside.empty());
  EXPECT_EQ(read, inside);
  for_all_events(recording, 0, [](auto) {});
  EXPECT_EQ(recording.problems().broken_packets, 8U) << "the others are broken indeed";
  for_all_events(recording, 0, [](auto) {});
  EXPECT_EQ(recording.problems().broken_packets, 8U) << "and are counted once";
}

TEST_F(DamagedRecording, CutByTimeKeepsTheBeginAndLeavesTheEnd) {
  RecordingReader recording = reader_of(vendor_bytes("dv-zstd"));
  const auto all = test::contents_of(recording).events;
  const CameraTime begin = all[1000].t;
  const CameraTime end = all[4000].t;
  std::vector<Event> read;
  for_events_between(recording, 0, begin, end, [&](auto events) { read.insert(read.end(), events.begin(), events.end()); });
  std::vector<Event> expected;
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected), [&](const Event& e) { return e.t >= begin && e.t < end; });
  EXPECT_EQ(read, expected);
  for_events_between(recording, 0, begin, begin, [](auto) { FAIL() << "an empty span holds nothing"; });
}

}  // namespace
}  // namespace tactile::events
