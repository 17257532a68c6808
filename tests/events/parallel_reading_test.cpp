#include <gtest/gtest.h>

#include <filesystem>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

/// Two cameras and an inertial sensor, a few hundred packets of each.
class ParallelReading : public testing::Test {
 protected:
  fs::path write(Compression compression, bool closed = true) {
    const fs::path file = folder / (std::string(name_of(compression)) + (closed ? ".aedat4" : "-open.aedat4"));
    Stream second = event_stream_declaration({320, 240}, "DVXplorer_B");
    second.id = 1;
    RecordingWriter writer(
        file,
        {event_stream_declaration({640, 480}, "DVXplorer_A"), second, test::stream_of(2, StreamType::imu, "IMUS", "DVXplorer_A")},
        {.compression = compression, .packet_events = 500});
    for (std::int64_t t = 0; t < 1'000'000; t += 10'000) {
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

TEST_F(ParallelReading, SaysWhenTheFileBecomesShorterMeanwhile) {
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

TEST(EventChecks, FindWhatIsWrongAtEveryPlace) {
  const SensorSize size{64, 48};
  for (std::size_t count = 1; count < 40; ++count) {
    const std::vector<Event> sound = test::steady_events(count, 1'000, 3, size);
    EXPECT_TRUE(check_events(sound, size).inside);
    EXPECT_TRUE(check_events(sound, size).ascending);
    for (std::size_t i = 0; i < count; ++i) {
      const auto outside = [&](auto&& change) {
        std::vector<Event> events = sound;
        change(events[i]);
        return !check_events(events, size).inside;
      };
      EXPECT_TRUE(outside([](Event& e) { e.x = 64; })) << i << " of " << count;
      EXPECT_TRUE(outside([](Event& e) { e.y = 48; })) << i << " of " << count;
      EXPECT_TRUE(outside([](Event& e) { e.x = -1; })) << i << " of " << count;
      EXPECT_TRUE(outside([](Event& e) { e.y = -32'768; })) << i << " of " << count;
      EXPECT_TRUE(outside([](Event& e) { e.on = 2; })) << i << " of " << count;
      EXPECT_FALSE(outside([](Event& e) { e.x = 63, e.y = 47, e.on = 1, e.padding[0] = 7, e.padding[2] = 255; }))
          << i << " of " << count;
      std::vector<Event> falling = sound;
      falling[i].t = camera_time(i == 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min());
      EXPECT_EQ(check_events(falling, size).ascending, count == 1) << i << " of " << count;
    }
  }
  const std::vector<Event> any(9, Event{.t = camera_time(0), .x = 32'767, .y = 32'767, .on = 0});
  EXPECT_TRUE(check_events(any, {32'768, 32'768}).inside);
  EXPECT_FALSE(check_events(any, {32'767, 32'768}).inside);
  EXPECT_TRUE(check_events({}, size).inside);
}

}  // namespace
}  // namespace tactile
