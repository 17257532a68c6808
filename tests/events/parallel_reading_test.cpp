#include <fmt/core.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

namespace fs = std::filesystem;

/// Two cameras and an inertial sensor, a few hundred packets of each.
class ParallelReading : public testing::Test {
 protected:
  fs::path write(Compression compression, bool closed = true, std::int64_t begin_us = 0) {
    fs::path file = folder / (std::string(name_of(compression)) + (closed ? ".aedat4" : "-open.aedat4"));
    Stream second = event_stream_declaration({320, 240}, "DVXplorer_B");
    second.id = 1;
    RecordingWriter writer(
        file,
        {event_stream_declaration({640, 480}, "DVXplorer_A"), second, test::stream_of(2, StreamType::imu, "IMUS", "DVXplorer_A")},
        {.compression = compression, .packet_events = 500});
    for (std::int64_t t = begin_us; t < begin_us + 1'000'000; t += 10'000) {
      writer.write_events(0, test::steady_events(2'000, t, 5, {640, 480}));
      writer.write_events(1, test::steady_events(700, t, 14, {320, 240}));
      ImuSample sample;
      sample.t = camera_time(t);
      writer.write_imu(2, {&sample, 1});
    }
    writer.close();
    if (!closed) test::cut_off_table(file);
    return file;
  }
  test::TemporaryFolder folder;
};

TEST_F(ParallelReading, GivesWhatReadingOnOneThreadGives) {
  for (const auto compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    for (const bool closed : {true, false}) {
      const fs::path file = write(compression, closed);
      const test::RecordingContents expected = test::contents_of(file);
      ASSERT_EQ(expected.events.size(), 270'000U);
      for (const unsigned threads : {2U, 5U}) {
        RecordingReader recording(file, threads);
        EXPECT_EQ(recording.index(), closed ? PacketIndex::table : PacketIndex::scan);
        EXPECT_TRUE(test::same(test::contents_of(recording), expected));
        EXPECT_TRUE(test::same(test::contents_of(recording), expected)) << "from the start again";
        std::vector<Event> of_one;
        for_all_events(recording, 1,
                       [&](std::span<const Event> events) { of_one.insert(of_one.end(), events.begin(), events.end()); });
        EXPECT_EQ(of_one.size(), 70'000U);
      }
    }
  }
}

TEST_F(ParallelReading, AllowsAnyOrder) {
  const fs::path file = write(Compression::lz4);
  RecordingReader one(file), several(file, 4);
  std::vector<PacketRecord> packets;
  for (const PacketRecord& packet : one.packets()) {
    if (packet.stream_id < 2) packets.push_back(packet);
  }
  // Forward, then by leaps, the same one twice, backward, and forward again.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < 40; ++i) order.push_back(i);
  for (std::size_t i = 40; i < packets.size(); i += 7) order.insert(order.end(), {i, i, i + 1, i + 2, i + 3, i + 4, i + 5});
  for (std::size_t i = packets.size(); i > 0; --i) order.push_back(i - 1);
  for (std::size_t i = 0; i < packets.size(); ++i) order.push_back(i);
  for (const std::size_t i : order) {
    if (i >= packets.size()) continue;
    const auto expected = one.read_events(packets[i]);
    const auto read = several.read_events(packets[i]);
    ASSERT_TRUE(std::equal(read.begin(), read.end(), expected.begin(), expected.end())) << i;
  }
}

TEST_F(ParallelReading, EndsWellInTheMiddle) {
  const fs::path file = write(Compression::lz4);
  for (const std::size_t count : {0U, 1U, 4U, 5U, 6U, 50U}) {
    RecordingReader recording(file, 3);
    for (std::size_t i = 0; i < count; ++i) {
      if (recording.packets()[i].stream_id < 2) recording.read_events(recording.packets()[i]);
    }
  }
}

TEST_F(ParallelReading, ReportsAFileThatBecomesShorterMeanwhile) {
  for (const auto compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    for (const unsigned threads : {1U, 3U}) {
      const fs::path file = write(compression);
      RecordingReader recording(file, threads);
      const auto packets = recording.packets();
      recording.read_events(packets[0]);
      fs::resize_file(file, packets[packets.size() / 2].payload_offset + 3);
      std::size_t read = 0;
      try {
        for (const PacketRecord& packet : packets) {
          if (packet.stream_id < 2) recording.read_events(packet);
          ++read;
        }
        ADD_FAILURE() << "the second half is not there";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("became shorter"), std::string::npos) << e.what();
        EXPECT_GE(read, packets.size() / 2 - 1);
      }
      fs::remove(file);
    }
  }
}

TEST_F(ParallelReading, ReportsAFileThatIsReplacedMeanwhile) {
  for (const auto compression : {Compression::none, Compression::lz4}) {
    const fs::path later = folder / "later.aedat4";
    fs::rename(write(compression, true, 3'600'000'000), later);
    const fs::path file = write(compression);
    RecordingReader recording(file);
    for_all_events(recording, 0, [](std::span<const Event>) {});
    fs::copy_file(later, file, fs::copy_options::overwrite_existing);
    EXPECT_EQ(
        test::error_of([&] { for_all_events(recording, 0, [](std::span<const Event>) {}); }),
        fmt::format("{}: was written to while it was read: the packet at byte {} is no longer the one listed; expected it to "
                    "stay as it is",
                    file.string(), recording.packets()[0].payload_offset));
  }
}

}  // namespace
}  // namespace tactile::events
