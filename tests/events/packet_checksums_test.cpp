#include "tactile/events/packet_checksums.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "events/made_recording.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/events/repair.hpp"

namespace tactile::events {
namespace {

namespace fs = std::filesystem;

constexpr SensorSize sensor_of_file{64, 48};
constexpr std::uint64_t first_line = 16, record = 24;  // [B] of the file of checksums
constexpr std::size_t packets = 30;

/// A recording with checksums, as after a kill: without a data table.
class PacketChecksumsOf : public testing::Test {
 protected:
  void SetUp() override { write(Compression::none); }

  void write(Compression compression) {
    fs::remove(file);
    RecordingWriter writer(file, {event_stream_declaration(sensor_of_file, "DVXplorer_DXM00001")},
                           {.compression = compression, .checksums = true});
    writer.write_events(0, test::steady_events(100 * packets, 5'000'000, 100, sensor_of_file));
    writer.flush();
    fs::copy_file(file, killed, fs::copy_options::overwrite_existing);
    fs::copy_file(checksums_beside(file), checksums_beside(killed), fs::copy_options::overwrite_existing);
    writer.close();
  }

  static void flip(const fs::path& path, std::uint64_t at, int bit = 0) {
    std::string bytes = read_text(path);
    bytes.at(at) = static_cast<char>(bytes.at(at) ^ (1 << bit));
    write_whole(path, bytes);
  }

  static ChecksumHealth checked(const fs::path& recording) {
    return examine_recording(recording, {.checksums = true}).checksums.value_or(ChecksumHealth{});
  }

  test::TemporaryFolder folder;
  fs::path file = folder / "closed.aedat4", killed = folder / "killed.aedat4", out = folder / "out.aedat4";
};

TEST_F(PacketChecksumsOf, CoverEachPacketOfARecordingThatIsWritten) {
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    write(compression);
    EXPECT_EQ(fs::file_size(checksums_beside(killed)), first_line + record * (1 + packets));
    for (const fs::path& each : {killed, file}) {
      const ChecksumHealth health = checked(each);
      EXPECT_EQ(health.whole, packets) << each;
      EXPECT_EQ(health.damaged + health.not_covered, 0U) << each;
      EXPECT_FALSE(health.header_damaged) << each;
    }
  }
  EXPECT_FALSE(examine_recording(killed).checksums) << "they were not asked for";
}

TEST_F(PacketChecksumsOf, FindAFlippedBitThatOtherChecksMiss) {
  const auto there = test::packets_of(killed);
  flip(killed, test::event_offset(there.at(7), 50) + 12, 0);  // an event's polarity
  EXPECT_TRUE(examine_recording(killed).healthy());
  const RecordingHealth health = examine_recording(killed, {.checksums = true});
  ASSERT_EQ(health.checksums->damaged, 1U);
  EXPECT_EQ(health.checksums->whole, packets - 1);
  EXPECT_EQ(health.checksums->first_damaged.at(0).index, 7U);
  ASSERT_EQ(health.reasons.size(), 1U);
  EXPECT_NE(health.reasons.at(0).find("packet 7 of stream 0 at byte " + std::to_string(there.at(7).payload_offset - 8) +
                                      ", at 0.070000 s"),
            std::string::npos)
      << health.reasons.at(0);
}

TEST_F(PacketChecksumsOf, GiveNoTimeForAPacketThatCannotBeRead) {
  const PacketRecord packet = test::packets_of(killed).at(7);
  test::overwrite(killed, packet.payload_offset + 28, std::uint32_t{1'000'000});  // it claims more events than it has room for
  const RecordingHealth health = examine_recording(killed, {.checksums = true});
  ASSERT_FALSE(health.reasons.empty());
  const std::string place = "packet 7 of stream 0 at byte " + std::to_string(packet.payload_offset - 8);
  EXPECT_EQ(health.reasons.back(), "1 packet has a wrong checksum: " + place);
}

TEST_F(PacketChecksumsOf, CountAllDamagedPacketsAndListTheFirst) {
  const auto there = test::packets_of(killed);
  for (const std::size_t i : {3U, 9U, 20U}) flip(killed, test::event_offset(there.at(i), 50) + 13);
  const ChecksumHealth health = examine_recording(killed, {.listed = 2, .checksums = true}).checksums.value();
  EXPECT_EQ(health.damaged, 3U);
  ASSERT_EQ(health.first_damaged.size(), 2U);
  EXPECT_EQ(health.first_damaged[0].index, 3U);
  EXPECT_EQ(health.first_damaged[1].index, 9U);
}

TEST_F(PacketChecksumsOf, FindEveryBitOfAPacketAndOfTheHeader) {
  const auto there = test::packets_of(killed);
  const std::string whole = read_text(killed);
  const std::uint64_t begin = there.at(2).payload_offset, end = begin + there.at(2).payload_size;
  for (std::uint64_t at = begin; at < end; at += 37) {
    flip(killed, at, static_cast<int>(at % 8));
    EXPECT_GE(checked(killed).damaged, 1U) << "byte " << at;
    write_whole(killed, whole);
  }
  const auto header = static_cast<std::uint64_t>(whole.find("DVXplorer"));
  flip(killed, header);
  EXPECT_TRUE(checked(killed).header_damaged);
  EXPECT_EQ(checked(killed).whole, packets);
}

TEST_F(PacketChecksumsOf, ReportWhatIsNotCoveredAndIgnoreWhatIsNotThere) {
  const std::uint64_t whole = fs::file_size(checksums_beside(killed));
  fs::resize_file(checksums_beside(killed), whole - 3 * record - 5);  // the fourth from the end is torn
  ChecksumHealth health = checked(killed);
  EXPECT_EQ(health.whole, packets - 4);
  EXPECT_EQ(health.not_covered, 4U);
  EXPECT_EQ(health.damaged, 0U);
  fs::resize_file(checksums_beside(killed), whole);  // zeros, as a power cut leaves them
  health = checked(killed);
  EXPECT_EQ(health.not_covered, 4U);
  EXPECT_EQ(health.damaged, 0U);

  fs::copy_file(checksums_beside(file), checksums_beside(killed), fs::copy_options::overwrite_existing);
  const PacketRecord last = test::packets_of(killed).at(packets - 6);
  fs::resize_file(killed, last.payload_offset + last.payload_size);  // the recording is the shorter one
  const RecordingHealth shorter = examine_recording(killed, {.checksums = true});
  EXPECT_EQ(shorter.checksums->whole, packets - 5);
  EXPECT_TRUE(shorter.healthy()) << shorter.reasons.at(0);

  fs::resize_file(checksums_beside(killed), 0);
  EXPECT_EQ(checked(killed).not_covered, packets - 5);
  fs::remove(checksums_beside(killed));
  EXPECT_FALSE(examine_recording(killed, {.checksums = true}).checksums);
}

TEST_F(PacketChecksumsOf, CoverNothingWhereTheirOwnBitsFlipped) {
  for (std::uint64_t at = first_line + 10 * record; at < first_line + 11 * record; ++at) {
    flip(checksums_beside(killed), at, static_cast<int>(at % 8));
    const ChecksumHealth health = checked(killed);
    EXPECT_EQ(health.not_covered, 1U);
    EXPECT_EQ(health.damaged, 0U);
    flip(checksums_beside(killed), at, static_cast<int>(at % 8));
  }
}

TEST_F(PacketChecksumsOf, AreNotUsedForAnotherRecordingInTheSamePlace) {
  flip(killed, test::event_offset(test::packets_of(killed).at(3), 1));
  const RepairSummary summary = repair_recording(killed, out);
  EXPECT_EQ(summary.packets_damaged, 1U);
  fs::rename(out, killed);
  const RecordingHealth health = examine_recording(killed, {.checksums = true});
  EXPECT_FALSE(health.checksums);
  EXPECT_TRUE(health.healthy());
  EXPECT_EQ(repair_recording(killed, out).packets_kept(), packets - 1);
}

TEST_F(PacketChecksumsOf, LetARepairLeaveOutWhatIsNotAsWritten) {
  const auto there = test::packets_of(killed);
  flip(killed, test::event_offset(there.at(7), 50) + 13, 0);
  flip(killed, test::event_offset(there.at(20), 0) + 2, 3);
  const RepairSummary summary = repair_recording(killed, out);
  EXPECT_EQ(summary.packets_damaged, 2U);
  EXPECT_EQ(summary.packets_lost(), 2U);
  EXPECT_EQ(summary.packets_kept(), packets - 2);
  EXPECT_TRUE(examine_recording(out).healthy());
  const std::string bytes = read_text(file), kept = read_text(out);
  for (std::size_t i = 0; i < packets; ++i) {
    const bool is_kept = kept.find(bytes.substr(there[i].payload_offset, there[i].payload_size)) != std::string::npos;
    EXPECT_EQ(is_kept, i != 7 && i != 20) << "packet " << i;
  }
}

TEST_F(PacketChecksumsOf, LetARepairKeepAPacketWhoseSizeAloneIsDamaged) {
  const PacketRecord packet = test::packets_of(killed).at(5);
  flip(killed, packet.payload_offset - 4, 4);
  const RepairSummary summary = repair_recording(killed, out);
  EXPECT_EQ(summary.problems.resized_packets, 1U);
  EXPECT_EQ(summary.packets_damaged, 0U);
  EXPECT_EQ(summary.packets_kept(), packets);
}

TEST_F(PacketChecksumsOf, AreGivenUpWhereTheyCannotBeWritten) {
  const fs::path other = folder / "other.aedat4";
  fs::create_directory(checksums_beside(other));
  RecordingWriter writer(other, {event_stream_declaration(sensor_of_file, "DVXplorer_DXM00001")}, {.checksums = true});
  writer.write_events(0, test::steady_events(1000, 0, 100, sensor_of_file));
  writer.close();
  EXPECT_TRUE(examine_recording(other, {.checksums = true}).healthy());
}

}  // namespace
}  // namespace tactile::events
