#include "tactile/capture/file_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "capture/received.hpp"
#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/comes_true.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

events::ImuSample sample_at(std::int64_t t_us) {
  events::ImuSample sample;
  sample.t = camera_time(t_us);
  sample.temperature_c = static_cast<float>(t_us % 100);
  return sample;
}

events::Stream sized(events::Stream stream) {
  stream.size = events::SensorSize{640, 480};
  return stream;
}

/// Events every 100 us for 0.2 s, a sample every millisecond, a trigger every 50 ms, from an ordinary time on.
constexpr std::int64_t begin_us = 1'605'537'493'718'345;
void write_camera(const fs::path& file, std::chrono::microseconds packet_span = 10ms, std::size_t packet_events = 8192) {
  events::RecordingWriter writer(
      file,
      {sized(test::stream_of(0, events::StreamType::events, "EVTS")), test::stream_of(2, events::StreamType::imu, "IMUS"),
       test::stream_of(3, events::StreamType::triggers, "TRIG")},
      {.packet_span = packet_span, .packet_events = packet_events});
  writer.write_events(0, test::steady_events(2000, begin_us, 100, {640, 480}));
  for (std::int64_t i = 0; i < 200; ++i) {
    const std::array samples{sample_at(begin_us + 1000 * i)};
    writer.write_imu(2, samples);
  }
  for (std::int64_t i = 0; i < 4; ++i) {
    const std::array triggers{events::Trigger{.t = camera_time(begin_us + 50'000 * i), .type = 1}};
    writer.write_triggers(3, triggers);
  }
  writer.close();
}

void write_events_of(const fs::path& file, const std::vector<std::string>& sources) {
  std::vector<events::Stream> streams;
  for (std::size_t i = 0; i < sources.size(); ++i)
    streams.push_back(sized(test::stream_of(static_cast<std::int32_t>(i), events::StreamType::events, "EVTS", sources[i])));
  events::RecordingWriter writer(file, streams);
  for (std::size_t i = 0; i < sources.size(); ++i)
    writer.write_events(static_cast<std::int32_t>(i), test::steady_events(10, 0, 10, {640, 480}));
  writer.close();
}

class ReplayOf : public testing::TestWithParam<std::chrono::microseconds> {};

TEST_P(ReplayOf, HasEveryElementOnceInOrderInPacketsShorterThanTenMilliseconds) {
  const test::TemporaryFolder folder;
  const fs::path file = folder / "a.aedat4";
  write_camera(file, GetParam(), 1 << 20);
  const auto source = open_file_source("file:a", file, {.speed = 0});
  ASSERT_EQ(source->streams().size(), 3U);
  EXPECT_FALSE(source->live());
  const test::Received all = test::receive_all(*source);
  const test::RecordingContents stored = test::contents_of(file);
  EXPECT_EQ(all.streams.at(0).events, stored.events);
  EXPECT_TRUE(test::same(all.streams.at(2).imu, stored.imu));
  EXPECT_TRUE(test::same(all.streams.at(3).triggers, stored.triggers));
  EXPECT_LT(all.longest_packet, 10ms);
  EXPECT_TRUE(std::is_sorted(all.begins.begin(), all.begins.end())) << "packets of all streams by their first times";
  EXPECT_EQ(source->drops().events + source->drops().packets, 0U);
  CameraPacket packet;
  EXPECT_EQ(source->receive(packet, milliseconds(1)), CameraSource::Received::ended) << "and it stays so";
}

INSTANTIATE_TEST_SUITE_P(Packets, ReplayOf,
                         testing::Values(std::chrono::microseconds(700), std::chrono::microseconds(10'000),
                                         std::chrono::microseconds(10'000'000)));

TEST(FileSource, LeavesShortPacketsAsTheyAreStored) {
  const test::TemporaryFolder folder;
  write_camera(folder / "a.aedat4", 3ms);
  const auto source = open_file_source("file:a", folder / "a.aedat4", {.speed = 0});
  const test::Received all = test::receive_all(*source);
  EXPECT_EQ(all.order.size(), test::packets_of(folder / "a.aedat4").size());
}

TEST(FileSource, TakesItsOwnTimeOverTheSpeed) {
  const test::TemporaryFolder folder;
  write_camera(folder / "a.aedat4");
  const auto source = open_file_source("file:a", folder / "a.aedat4", {.speed = 2});
  EXPECT_TRUE(source->live());
  const auto begun = std::chrono::steady_clock::now();
  const test::Received all = test::receive_all(*source);
  EXPECT_GE(std::chrono::steady_clock::now() - begun, milliseconds(99)) << "200 ms at twice their pace";
  EXPECT_EQ(all.streams.at(0).events.size(), 2000U);
}

TEST(FileSource, GivesNothingWhileNothingIsDueAndLosesNothingByIt) {
  const test::TemporaryFolder folder;
  write_camera(folder / "a.aedat4");
  const std::vector<events::Event> events = test::contents_of(folder / "a.aedat4").events;
  // Packets come every 20 ms. On a busy machine each may be due by the time it is asked for: then it is played once more.
  EXPECT_TRUE(test::comes_true([&] {
    const auto source = open_file_source("file:a", folder / "a.aedat4", {.speed = 0.5});
    test::Received all;
    CameraPacket packet;
    int nothing = 0;
    for (;;) {
      const auto received = source->receive(packet, milliseconds(1));
      if (received == CameraSource::Received::ended) break;
      if (received == CameraSource::Received::packet) test::add(packet, all);
      if (received == CameraSource::Received::nothing) ++nothing;
    }
    EXPECT_EQ(all.streams.at(0).events, events);
    return nothing > 0;
  }));
}

TEST(FileSource, ReportsWhatItReplaysAndWhetherAnyCameraSawIt) {
  const test::TemporaryFolder folder;
  const fs::path run = folder / "fan" / "01";
  fs::create_directories(run);
  write_camera(run / "events.aedat4");
  EXPECT_FALSE(open_file_source("file:x", run, {.speed = 0})->simulated());
  write_json(run / "run.json", {{"simulated", true}, {"camera", {{"readout_mode", "constant-500"}, {"source", "other"}}}});
  const auto source = open_file_source("file:x", run, {.speed = 0});
  EXPECT_EQ(source->name(), "file:x");
  EXPECT_TRUE(source->simulated());
  EXPECT_EQ(source->camera().at("source"), "DVXplorer_DXM00001") << "the stream knows best";
  EXPECT_EQ(source->camera().at("readout_mode"), "constant-500");
  EXPECT_EQ(source->camera().at("replay_of"), (run / "events.aedat4").string());
  write_whole(run / "run.json", "{ no JSON");
  EXPECT_FALSE(open_file_source("file:x", run, {.speed = 0})->simulated());

  events::Stream stream = events::event_stream_declaration({640, 480}, "DVXplorer_SIM00001");
  stream.info = {{"simulated", "true"}, {"readoutMode", "constant"}};
  events::RecordingWriter writer(folder / "sim.aedat4", {stream});
  writer.write_events(0, test::steady_events(10, 0, 10, {640, 480}));
  writer.close();
  const auto attributed = open_file_source("file:sim", folder / "sim.aedat4", {.speed = 0});
  EXPECT_TRUE(attributed->simulated());
  EXPECT_EQ(attributed->camera().at("readout_mode"), "constant");
}

TEST(FileSource, WantsOneCamera) {
  const test::TemporaryFolder folder;
  write_events_of(folder / "two.aedat4", {"DVXplorer_A", "DVXplorer_B"});
  try {
    open_file_source("file:two", folder / "two.aedat4", {.speed = 0});
    FAIL() << "it was opened";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("DVXplorer_B"), std::string::npos) << error.what();
  }
}

TEST(FileSource, LeavesOutAndCountsWhatCannotBeRecorded) {
  const test::TemporaryFolder folder;
  const fs::path file = folder / "bad.aedat4";
  test::write_plain_recording(file, test::steady_events(100, 1'000, 10, {640, 480}), {640, 480});
  const events::PacketRecord packet = test::packets_of(file).front();
  test::overwrite(file, test::event_offset(packet, 50), std::int64_t{1'100});    // a step back
  test::overwrite(file, test::event_offset(packet, 60) + 8, std::int16_t{640});  // beside the sensor
  const auto source = open_file_source("file:bad", file, {.speed = 0});
  const test::Received all = test::receive_all(*source);
  EXPECT_EQ(all.streams.at(0).events.size(), 98U);
  EXPECT_EQ(source->drops().events, 2U);
  EXPECT_EQ(source->drops().back_in_time.events, 1U);
}

TEST(FileSource, EndsInWordsWhereAClockOf31BitsBeganAgain) {
  const test::TemporaryFolder folder;
  const fs::path file = folder / "wrapped.aedat4";
  constexpr std::int64_t end = std::int64_t{1} << 31;
  test::write_plain_recording(file, test::steady_events(200, end - 1'000, 10, {640, 480}), {640, 480});
  std::size_t k = 0;
  for (const events::PacketRecord& packet : test::packets_of(file)) {
    for (std::int64_t i = 0; i < packet.elements; ++i, ++k) {
      const std::int64_t t = end - 1'000 + 10 * static_cast<std::int64_t>(k);
      test::overwrite(file, test::event_offset(packet, static_cast<std::size_t>(i)), t % end);
    }
  }
  const auto source = open_file_source("file:wrapped", file, {.speed = 0});
  try {
    test::receive_all(*source);
    FAIL() << "times of two rounds were taken for one";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("its time went back by 2147.48"), std::string::npos) << error.what();
  }
}

TEST(FileSource, PlaysRealRecordingsOfTheVendors) {
  for (const char* name : {"dv-lz4.aedat4", "dv-zstd.aedat4", "dv-none.aedat4"}) {
    const fs::path file = test::vendor_files / name;
    const auto source = open_file_source(name, file, {.speed = 0});
    const test::Received all = test::receive_all(*source);
    test::RecordingContents stored = test::contents_of(file);
    std::vector<events::Event> events;
    for (const auto& [id, stream] : all.streams) events.insert(events.end(), stream.events.begin(), stream.events.end());
    EXPECT_EQ(events, stored.events) << name;
    EXPECT_FALSE(events.empty()) << name;
  }
}

}  // namespace
}  // namespace tactile::capture
