#include "tactile/events/repair.hpp"

#include <gtest/gtest.h>

#include <array>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile::events {
namespace {

using test::files_in;
using test::stored_bytes;
using test::vendor_files;

namespace fs = std::filesystem;

/// A copy of a file of the vendor's, cut or damaged as the test likes.
class Repair : public testing::Test {
 protected:
  void take(const std::string& name) { fs::copy_file(vendor_files / name, in); }

  test::TemporaryFolder folder;
  fs::path in = folder / "in.aedat4";
  fs::path out = folder / "out.aedat4";
};

TEST_F(Repair, GivesASoundRecordingAgainPacketByPacket) {
  for (const char* name : {"dv-none.aedat4", "dv-lz4.aedat4", "dv-lz4-high.aedat4", "dv-zstd.aedat4", "dv-zstd-high.aedat4"}) {
    fs::remove(in);
    fs::remove(out);
    take(name);
    const RepairSummary summary = repair_recording(in, out);
    EXPECT_EQ(summary.packets_kept(), 16U);
    EXPECT_EQ(summary.packets_lost(), 0U);
    EXPECT_EQ(summary.packets_rewritten, 0U);
    EXPECT_EQ(summary.bytes_lost(), 0U);
    const auto before = test::packets_of(in);
    const auto after = test::packets_of(out);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(stored_bytes(in, before[i]), stored_bytes(out, after[i])) << name << ", packet " << i;
      EXPECT_EQ(before[i].elements, after[i].elements);
      EXPECT_EQ(before[i].first, after[i].first);
      EXPECT_EQ(before[i].last, after[i].last);
    }
    EXPECT_EQ(RecordingReader(out).index(), PacketIndex::table) << name;
    EXPECT_TRUE(examine_recording(out).healthy()) << name;
  }
}

TEST_F(Repair, KeepsStreamsWithTheirSourcesAndAttributes) {
  {
    RecordingWriter writer(
        in, {event_stream_declaration({64, 48}, "DVXplorer_A"), test::stream_of(7, StreamType::imu, "IMUS", "DVXplorer_B")});
    writer.write_events(0, test::steady_events(10, 0, 1, {64, 48}));
    writer.close();
  }
  repair_recording(in, out);
  const RecordingReader repaired(out);
  ASSERT_EQ(repaired.streams().size(), 2U);
  EXPECT_EQ(repaired.stream(0).source, "DVXplorer_A");
  EXPECT_EQ(repaired.stream(0).size, (SensorSize{64, 48}));
  EXPECT_EQ(repaired.stream(7).source, "DVXplorer_B");
  EXPECT_EQ(repaired.stream(7).info, (std::vector<std::pair<std::string, std::string>>{{"tsOffset", "1605507430438338"}}));
}

TEST_F(Repair, KeepsEveryWholePacketWhereverTheRecordingWasCut) {
  take("dv-lz4.aedat4");
  const auto packets = test::packets_of(in);
  const test::RecordingContents whole = test::contents_of(in);
  const std::uint64_t begin = packets.front().payload_offset - 8;
  const std::uint64_t size = fs::file_size(in);
  for (std::uint64_t length = begin + 1; length < size; length += 1'013) {
    fs::remove(out);
    fs::copy_file(vendor_files / "dv-lz4.aedat4", in, fs::copy_options::overwrite_existing);
    fs::resize_file(in, length);
    const auto fits = static_cast<std::uint64_t>(std::count_if(packets.begin(), packets.end(), [&](const PacketRecord& packet) {
      return packet.payload_offset + packet.payload_size <= length;
    }));
    if (fits == 0) {
      EXPECT_THROW(repair_recording(in, out), Error);
      EXPECT_FALSE(fs::exists(out));
      continue;
    }
    const RepairSummary summary = repair_recording(in, out);
    EXPECT_EQ(summary.packets_kept(), fits) << "cut to " << length;
    EXPECT_EQ(RecordingReader(out).index(), PacketIndex::table);
    const test::RecordingContents kept = test::contents_of(out);
    ASSERT_LE(kept.events.size(), whole.events.size());
    EXPECT_TRUE(std::equal(kept.events.begin(), kept.events.end(), whole.events.begin())) << "cut to " << length;
    const RecordingHealth health = examine_recording(out);
    EXPECT_TRUE(health.healthy() || kept.events.empty()) << "cut to " << length;
  }
}

TEST_F(Repair, ReportsHowManyBytesWereCutOff) {
  test::write_plain_recording(in, test::steady_events(3'000, 0, 100, {64, 48}), {64, 48});
  const PacketRecord last = test::packets_of(in).back();
  fs::resize_file(in, last.payload_offset + 100);
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.problems.truncated_bytes, 108U);
  EXPECT_EQ(summary.bytes_lost(), 108U);
  EXPECT_EQ(summary.packets_kept(), 29U);
  EXPECT_EQ(summary.streams.at(0).elements_kept, 2'900U);
  EXPECT_EQ(summary.index, PacketIndex::scan);
}

TEST_F(Repair, DropsPacketsThatDoNotDecodeOrHoldAnotherType) {
  test::write_plain_recording(in, test::steady_events(3'000, 0, 100, {64, 48}), {64, 48});
  const auto packets = test::packets_of(in);
  test::overwrite(in, packets[3].payload_offset + 28, std::uint32_t{1'000'000});
  test::overwrite(in, packets[8].payload_offset + 8, std::array{'I', 'M', 'U', 'S'});
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.packets_kept(), 28U);
  EXPECT_EQ(summary.packets_lost(), 2U);
  EXPECT_EQ(summary.bytes_lost(), packets[3].payload_size + packets[8].payload_size + 16U);
  EXPECT_EQ(summary.problems.broken_packets, 1U);
  EXPECT_EQ(summary.problems.mismatched_packets, 1U);
  EXPECT_TRUE(examine_recording(out).healthy());
  EXPECT_EQ(test::contents_of(out).events.size(), 2'800U);
}

TEST_F(Repair, DropsEventsOutsideTheSensorAndLeavesTheOtherPacketsAlone) {
  for (const bool closed : {true, false}) {
    fs::remove(in);
    fs::remove(out);
    const std::vector<Event> events = test::steady_events(3'000, 0, 100, {64, 48});
    test::write_plain_recording(in, events, {64, 48});
    const auto packets = test::packets_of(in);
    test::overwrite(in, test::event_offset(packets[1], 4) + 8, std::int16_t{64});
    test::overwrite(in, test::event_offset(packets[1], 99) + 10, std::int16_t{-1});
    if (!closed) test::cut_off_table(in);
    const RepairSummary summary = repair_recording(in, out);
    EXPECT_EQ(summary.packets_kept(), 30U);
    EXPECT_EQ(summary.packets_rewritten, 1U);
    EXPECT_EQ(summary.problems.out_of_range_events, 2U);
    EXPECT_TRUE(examine_recording(out).healthy());

    std::vector<Event> expected = events;
    expected.erase(expected.begin() + 199);
    expected.erase(expected.begin() + 104);
    EXPECT_EQ(test::contents_of(out).events, expected);
  }
}

TEST_F(Repair, PutsTimesRightThatWrapped) {
  const std::int64_t wrap = std::int64_t{1} << 32;
  test::write_plain_recording(in, test::steady_events(3'000, wrap / 2, 100, {64, 48}), {64, 48});
  const test::RecordingContents whole = test::contents_of(in);
  const auto packets = test::packets_of(in);
  for (std::size_t p = 10; p < packets.size(); ++p) {
    for (std::size_t i = 0; i < 100; ++i)
      test::overwrite(in, test::event_offset(packets[p], i), us_of(whole.events[100 * p + i].t) - wrap);
  }
  test::cut_off_table(in);
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.packets_rewritten, 20U);
  EXPECT_EQ(summary.problems.unwrapped_packets, 20U);
  EXPECT_EQ(test::contents_of(out).events, whole.events);
  EXPECT_TRUE(examine_recording(out).notes.empty());
}

TEST_F(Repair, LeavesStepsBackInTimeAsTheyAreAndCountsThem) {
  test::write_plain_recording(in, test::steady_events(300, 1'000, 100, {64, 48}), {64, 48});
  test::overwrite(in, test::event_offset(test::packets_of(in).front(), 4), std::int64_t{1'000});
  const test::RecordingContents before = test::contents_of(in);
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.streams.at(0).steps_back, 1U);
  EXPECT_EQ(summary.packets_rewritten, 0U);
  EXPECT_EQ(test::contents_of(out).events, before.events);
}

TEST_F(Repair, WritesATableThatIsBelievedWhereTimeStepsBack) {
  test::write_plain_recording(in, test::steady_events(300, 10'000, 100, {64, 48}), {64, 48});
  test::overwrite(in, test::event_offset(test::packets_of(in)[1], 99), std::int64_t{1'000});  // the last of its packet
  repair_recording(in, out);
  const RecordingReader repaired(out);
  EXPECT_EQ(repaired.index(), PacketIndex::table) << repaired.problems().table;
  EXPECT_EQ(repaired.packets()[1].first, camera_time(1'000));
  EXPECT_EQ(repaired.packets()[1].last, camera_time(29'800));
}

TEST_F(Repair, MovesNothingForOneDamagedTime) {
  const std::int64_t wrap = std::int64_t{1} << 32;
  for (const std::int64_t off : {wrap, -wrap}) {
    for (const bool closed : {true, false}) {
      for (const fs::path& file : {in, out}) fs::remove(file);
      const std::vector<Event> events = test::steady_events(3'000, 2 * wrap, 100, {64, 48});
      test::write_plain_recording(in, events, {64, 48});
      test::overwrite(in, test::event_offset(test::packets_of(in)[2], 40), us_of(events[240].t) + off);
      if (!closed) test::cut_off_table(in);
      EXPECT_FALSE(examine_recording(in).healthy());
      const RepairSummary summary = repair_recording(in, out);
      EXPECT_EQ(summary.packets_rewritten, 0U);
      EXPECT_EQ(summary.streams.at(0).steps_back, 1U);
      std::vector<Event> expected = events;
      expected[240].t += microseconds{off};
      EXPECT_EQ(test::contents_of(out).events, expected);
    }
  }
}

TEST_F(Repair, KeepsPacketsOfTypesItDoesNotKnow) {
  test::write_plain_recording(in, test::steady_events(300, 0, 100, {64, 48}), {64, 48});
  std::string bytes = read_text(in);
  for (std::size_t at = bytes.find("EVTS"); at != std::string::npos; at = bytes.find("EVTS", at)) bytes.replace(at, 4, "BBOX");
  write_whole(in, bytes);
  const RepairSummary summary = repair_recording(in, out);
  EXPECT_EQ(summary.packets_kept(), 3U);
  const RecordingReader repaired(out);
  EXPECT_EQ(repaired.streams().front().type_identifier, "BBOX");
  EXPECT_EQ(repaired.packets().size(), 3U);
  EXPECT_EQ(stored_bytes(in, test::packets_of(in).back()), stored_bytes(out, test::packets_of(out).back()));
}

TEST_F(Repair, RefusesARecordingWithoutAWholePacketAndLeavesNothing) {
  take("dv-lz4.aedat4");
  fs::resize_file(in, test::packets_of(in).front().payload_offset + 10);
  EXPECT_THROW(repair_recording(in, out), Error);
  fs::resize_file(in, 20);
  EXPECT_THROW(repair_recording(in, out), Error);
  fs::resize_file(in, 0);
  EXPECT_THROW(repair_recording(in, out), Error);
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST_F(Repair, NeverReplacesItsInputUnderAnyName) {
  take("dv-lz4.aedat4");
  const std::string before = read_text(in);
  fs::create_hard_link(in, folder / "hard.aedat4");
  fs::create_symlink(in, folder / "soft.aedat4");
  fs::create_directory(folder / "inner");
  for (const fs::path& same : {in, folder / "hard.aedat4", folder / "soft.aedat4", folder / "inner" / ".." / "in.aedat4"}) {
    for (const bool replace : {false, true}) EXPECT_THROW(repair_recording(in, same, replace), Error) << same;
  }
  EXPECT_EQ(read_text(in), before);
}

TEST_F(Repair, ReplacesAnotherFileOnlyOnRequest) {
  take("dv-lz4.aedat4");
  write_whole(out, "precious");
  EXPECT_THROW(repair_recording(in, out), Error);
  EXPECT_EQ(read_text(out), "precious");
  EXPECT_EQ(repair_recording(in, out, true).packets_kept(), 16U);
  EXPECT_TRUE(examine_recording(out).healthy());
}

TEST_F(Repair, WritesOnlyAedat4) {
  take("dv-lz4.aedat4");
  EXPECT_THROW(repair_recording(in, folder / "out.csv"), Error);
  EXPECT_THROW(repair_recording(in, folder / "out"), Error);
}

}  // namespace
}  // namespace tactile::events
