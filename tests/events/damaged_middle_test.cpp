// Recordings damaged between their ends: everything on both sides of the damage is found again, and what is lost is counted.
#include <gtest/gtest.h>

#include <algorithm>

#include "events/aedat4_bytes.hpp"
#include "events/recording_contents.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/repair.hpp"

namespace tactile::events {
namespace {

using test::event;
using test::get;
using test::put;

/// Twelve packets of one camera in one compression, with a table or without.
class DamagedMiddle : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  static constexpr std::size_t packets = 12;

  DamagedMiddle() {
    bytes = test::file_start(compression(), test::xml_of(test::event_node(0, 640, 480, "DVXplorer_DXM00001")));
    for (std::size_t p = 0; p < packets; ++p) {
      for (int i = 0; i < 300; ++i)
        all.push_back(event(static_cast<std::int64_t>(1000 * p) + i, (7 * i + static_cast<int>(p)) % 640, (i * i) % 480, i % 2));
      const std::string plain = test::event_payload({all.end() - 300, all.end()});
      const std::string payload = compression() == 0 ? plain : compression() == 1 ? test::lz4(plain) : test::zstd(plain);
      places.push_back({.id = 0, .at = bytes.size(), .size = payload.size()});
      entries.push_back({.offset = static_cast<std::int64_t>(bytes.size() + 8),
                         .id = 0,
                         .size = static_cast<std::int32_t>(payload.size()),
                         .elements = 300,
                         .first = static_cast<std::int64_t>(1000 * p),
                         .last = static_cast<std::int64_t>(1000 * p + 299)});
      bytes += test::packet(0, payload);
    }
    data_end = bytes.size();
    if (has_table()) bytes = test::with_table(bytes, test::table_of(entries));
  }
  static int compression() { return std::get<0>(GetParam()); }
  static bool has_table() { return std::get<1>(GetParam()); }

  RecordingReader reader() {
    return RecordingReader(test::write_bytes(folder / ("recording" + std::to_string(++made) + ".aedat4"), bytes));
  }
  /// The events without those of the packets [first, first + count).
  std::vector<Event> all_but(std::size_t first, std::size_t count) const {
    std::vector<Event> rest = all;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(300 * first),
               rest.begin() + static_cast<std::ptrdiff_t>(300 * (first + count)));
    return rest;
  }

  test::TemporaryFolder folder;
  std::string bytes;
  std::size_t data_end = 0;
  std::vector<Event> all;
  std::vector<test::PacketPlace> places;
  std::vector<test::TableEntry> entries;
  int made = 0;
};

TEST_P(DamagedMiddle, IsNoneInASoundRecording) {
  RecordingReader recording = reader();
  EXPECT_EQ(recording.index(), has_table() ? PacketIndex::table : PacketIndex::scan) << recording.problems().table;
  EXPECT_EQ(recording.problems().skipped_bytes, 0U);
  EXPECT_EQ(recording.problems().resized_packets, 0U);
  EXPECT_EQ(test::contents_of(recording).events, all);
}

TEST_P(DamagedMiddle, LosesThePacketWhoseHeaderIsOverwrittenAndNoOther) {
  for (const std::size_t hit : {std::size_t{0}, std::size_t{5}, packets - 1}) {
    const std::string sound = bytes;
    put(bytes, places[hit].at, std::uint64_t{0xdeadbeefdeadbeef});
    RecordingReader recording = reader();
    if (has_table()) {  // its place and length are known
      EXPECT_EQ(recording.problems().skipped_bytes, 8U) << hit;
      EXPECT_EQ(test::contents_of(recording).events, all) << hit;
    } else if (hit + 1 == packets) {
      EXPECT_EQ(recording.problems().truncated_bytes, 8 + places[hit].size);
      EXPECT_EQ(test::contents_of(recording).events, all_but(hit, 1));
    } else {
      EXPECT_EQ(recording.problems().skipped_bytes, 8 + places[hit].size) << hit;
      EXPECT_EQ(recording.problems().truncated_bytes, 0U) << hit;
      EXPECT_EQ(test::contents_of(recording).events, all_but(hit, 1)) << hit;
    }
    bytes = sound;
  }
}

TEST_P(DamagedMiddle, GivesAPacketItsSizeBack) {
  const auto right = static_cast<std::int32_t>(places[5].size);
  for (const std::int32_t wrong : {right + 1, right + 40, right - 3, right / 2,
                                   right + 8 + static_cast<std::int32_t>(places[6].size) - 9, 1'000'000'000, -1}) {
    const std::string sound = bytes;
    put(bytes, places[5].at + 4, wrong);
    RecordingReader recording = reader();
    const RecordingProblems& problems = recording.problems();
    const std::vector<Event> events = test::contents_of(recording).events;
    if (wrong < 0 || wrong > 1'000'000) {  // no header at all: as one that is overwritten
      EXPECT_EQ(events, has_table() ? all : all_but(5, 1)) << wrong;
      EXPECT_EQ(problems.skipped_bytes, has_table() ? 8 : 8 + places[5].size) << wrong;
    } else {
      EXPECT_EQ(events, all) << wrong;
      EXPECT_EQ(problems.resized_packets, 1U) << wrong;
      EXPECT_EQ(problems.skipped_bytes, 0U) << wrong;
    }
    EXPECT_EQ(problems.broken_packets, 0U) << wrong;
    EXPECT_EQ(problems.truncated_bytes, 0U) << wrong;
    bytes = sound;
  }
}

TEST_P(DamagedMiddle, ResumesAfterASectorOfZerosOrOfNoise) {
  std::uint32_t state = 1;
  for (const bool zeros : {true, false}) {
    for (std::size_t begin = places[3].at; begin < places[5].at; begin += 97) {
      const std::string sound = bytes;
      const std::size_t end = std::min(begin + 2048, places[8].at);
      for (std::size_t i = begin; i < end; ++i)
        bytes[i] = zeros ? '\0' : static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
      RecordingReader recording = reader();
      std::vector<Event> events = test::contents_of(recording).events;
      // Each packet that was not touched at all is there, with every event of its own.
      for (std::size_t p = 0; p < packets; ++p) {
        if (places[p].end() > begin && places[p].at < end) continue;
        const auto first = std::find(events.begin(), events.end(), all[300 * p]);
        ASSERT_TRUE(first != events.end() && events.end() - first >= 300) << p << " at " << begin;
        EXPECT_TRUE(std::equal(first, first + 300, all.begin() + static_cast<std::ptrdiff_t>(300 * p))) << p << " at " << begin;
      }
      EXPECT_EQ(recording.problems().truncated_bytes, 0U) << begin;
      EXPECT_LT(recording.problems().empty_packets, 64U) << begin;
      if (compression() != 0) {  // uncompressed events look like events with any bytes
        EXPECT_GT(recording.problems().skipped_bytes + recording.problems().broken_packets, 0U) << begin;
      }
      bytes = sound;
    }
  }
}

TEST_P(DamagedMiddle, ResumesWhereBytesWereLostOrInserted) {
  const std::string sound = bytes;
  bytes.erase(places[4].at + 3, places[4].size);  // the rest of its contents, and the next header, follow where none is expected
  if (has_table()) put(bytes, test::position_at, static_cast<std::int64_t>(data_end - places[4].size));
  RecordingReader lost = reader();
  EXPECT_EQ(test::contents_of(lost).events, all_but(4, 1));
  bytes = sound;
  bytes.insert(places[4].at, "something that was never written by a camera");
  if (has_table()) put(bytes, test::position_at, static_cast<std::int64_t>(data_end + 44));
  RecordingReader inserted = reader();
  EXPECT_EQ(inserted.problems().skipped_bytes, 44U);
  EXPECT_EQ(test::contents_of(inserted).events, all);
}

TEST_P(DamagedMiddle, LosesOnePacketWhereAFewBytesWerePutIntoIt) {
  const std::string sound = bytes;
  for (std::size_t more = 1; more <= 12; ++more) {
    bytes.insert(places[4].at + 8 + places[4].size / 2, more, 'Z');
    if (has_table()) put(bytes, test::position_at, static_cast<std::int64_t>(data_end + more));
    RecordingReader recording = reader();
    const std::vector<Event> events = test::contents_of(recording).events;
    for (std::size_t p = 0; p < packets; ++p) {
      if (p == 4) continue;
      const auto first = std::find(events.begin(), events.end(), all[300 * p]);
      ASSERT_TRUE(first != events.end() && events.end() - first >= 300) << p << " with " << more;
      EXPECT_TRUE(std::equal(first, first + 300, all.begin() + static_cast<std::ptrdiff_t>(300 * p))) << p << " with " << more;
    }
    bytes = sound;
  }
}

TEST_P(DamagedMiddle, CountsWhatTheTableListsAndIsGone) {
  bytes.erase(places[4].at, places[6].at - places[4].at);  // two whole packets
  if (has_table()) put(bytes, test::position_at, static_cast<std::int64_t>(data_end - (places[6].at - places[4].at)));
  const auto in = test::write_bytes(folder / "in.aedat4", bytes);
  const RepairSummary summary = repair_recording(in, folder / "out.aedat4");
  EXPECT_EQ(summary.packets_kept(), packets - 2);
  EXPECT_EQ(summary.problems.missing_packets, has_table() ? 2U : 0U);
  EXPECT_EQ(summary.problems.missing_elements, has_table() ? 600U : 0U);
  const RecordingHealth health = examine_recording(in);
  EXPECT_EQ(health.healthy(), !has_table());
}

TEST_P(DamagedMiddle, IsFoundAgainWhereTheHeaderWasNotPatchedEither) {
  put(bytes, test::position_at, std::int64_t{-1});
  put(bytes, places[5].at, std::uint64_t{0xdeadbeefdeadbeef});
  RecordingReader recording = reader();
  EXPECT_EQ(test::contents_of(recording).events, has_table() ? all : all_but(5, 1));
  EXPECT_EQ(recording.problems().truncated_bytes, 0U);
}

TEST_P(DamagedMiddle, IsReportedByInfoAndRepairAndGoneAfterwards) {
  put(bytes, places[5].at, std::uint64_t{0xdeadbeefdeadbeef});
  const auto in = test::write_bytes(folder / "in.aedat4", bytes), out = folder / "out.aedat4";
  const RecordingHealth health = examine_recording(in);
  EXPECT_FALSE(health.healthy());
  EXPECT_TRUE(std::any_of(health.reasons.begin(), health.reasons.end(),
                          [](const std::string& reason) { return reason.starts_with("damaged: "); }));
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.bytes_lost(), has_table() ? 8 : 8 + places[5].size);
  EXPECT_EQ(summary.packets_kept(), has_table() ? packets : packets - 1);
  EXPECT_TRUE(examine_recording(out).healthy());
}

TEST_P(DamagedMiddle, DoesNotDependOnTheNumberOfThreads) {
  put(bytes, places[2].at, std::uint64_t{0xdeadbeefdeadbeef});
  put(bytes, places[7].at + 8, std::uint64_t{0xdeadbeefdeadbeef});  // its contents
  put(bytes, places[9].at + 4, static_cast<std::int32_t>(places[9].size + 1));
  const auto file = test::write_bytes(folder / "in.aedat4", bytes);
  RecordingReader one(file);
  const test::RecordingContents expected = test::contents_of(one);
  EXPECT_GT(one.problems().broken_packets, 0U);
  for (const unsigned threads : {2U, 3U, 8U}) {
    RecordingReader several(file, threads);
    EXPECT_TRUE(test::same(test::contents_of(several), expected)) << threads;
    EXPECT_EQ(several.problems().broken_packets, one.problems().broken_packets);
    EXPECT_EQ(several.problems().skipped_bytes, one.problems().skipped_bytes);
    EXPECT_TRUE(test::same(test::contents_of(several), expected)) << "read again";
    EXPECT_EQ(several.problems().broken_packets, one.problems().broken_packets);
  }
}

INSTANTIATE_TEST_SUITE_P(All, DamagedMiddle, testing::Combine(testing::Values(0, 1, 3), testing::Bool()),
                         [](const auto& instance) {
                           const int compression = std::get<0>(instance.param);
                           return std::string(compression == 0   ? "None"
                                              : compression == 1 ? "Lz4"
                                                                 : "Zstd") +
                                  (std::get<1>(instance.param) ? "WithTable" : "WithoutTable");
                         });

}  // namespace
}  // namespace tactile::events
