// What a run loses, and how it is counted.
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <memory>

#include "capture/recorded_run.hpp"
#include "support/events_in_file.hpp"
#include "support/file_size_limit.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::event_at;
using test::event_source;
using test::event_stream;
using test::events_in_file;
using test::MadeSource;
using test::noise;
using test::recorder_sensor;
using test::RunRecorderTest;
using test::sources_of;

TEST_F(RunRecorderTest, LeavesOutAndCountsWhatCannotBeWritten) {
  std::vector<events::Event> events = test::steady_events(1000, 100'000, 10, recorder_sensor);
  const std::vector<events::Event> sound = events;
  events.insert(events.begin() + 300, event_at(50'000, 1, 1));         // back in time
  events.insert(events.begin() + 400, event_at(200'000'000, 640, 1));  // beyond the sensor, and of no right time either
  events.insert(events.begin() + 500, event_at(us_of(events[499].t), 1, -1));
  events.insert(events.begin() + 600, event_at(us_of(events[599].t), 1, 1, 2));
  for (int i = 0; i < 10; ++i) events.push_back(event_at(60'000 + i, 2, 2));  // a whole packet of the past
  auto step = [next = 0, events](CameraPacket& packet, std::chrono::milliseconds) mutable {
    packet.stream_id = 0;
    switch (next++) {
      case 0:
        packet.events.assign(events.begin(), events.end() - 10);
        return CameraSource::Received::packet;
      case 1:
        packet.events.assign(events.end() - 10, events.end());
        return CameraSource::Received::packet;
      case 2:
        packet.stream_id = 5;  // nobody declared it
        packet.events.assign(3, event_at(1'000'000));
        return CameraSource::Received::packet;
      default:
        return CameraSource::Received::ended;
    }
  };
  RunRecorder recorder(sources_of(event_source(step)), nullptr, nullptr);
  const RunSummary summary = record(recorder);
  EXPECT_EQ(events_in_file(summary.run.events()), sound);
  EXPECT_EQ(summary.events, sound.size());
  EXPECT_EQ(summary.drops.back_in_time.events, 11U);
  EXPECT_EQ(summary.drops.back_in_time.packets, 1U);
  EXPECT_EQ(summary.drops.outside.events, 6U);
  EXPECT_EQ(summary.drops.outside.packets, 1U);
  EXPECT_TRUE(summary.complete);
  const nlohmann::json dropped = read_json(summary.run.info()).at("dropped");
  EXPECT_EQ(dropped.at("events"), 17);
  EXPECT_EQ(dropped.at("by_reason").at("back_in_time").at("events"), 11);
  EXPECT_EQ(dropped.at("by_reason").at("outside").at("events"), 6);
}

TEST_F(RunRecorderTest, DropsAndCountsWholePacketsWhereWritingIsTooSlow) {
  std::atomic<std::uint64_t> sent{0};
  RunRecorder recorder(sources_of(event_source(noise(300, sent))), nullptr, nullptr,
                       {.queue_bytes = 300'000, .compression = events::Compression::zstd_high});
  const RunSummary summary = record(recorder);
  EXPECT_EQ(sent, 300U * 8192U);
  EXPECT_GT(summary.drops.queue_full.packets, 0U);
  EXPECT_EQ(summary.drops.queue_full.events, 8192 * summary.drops.queue_full.packets);
  EXPECT_EQ(summary.events + summary.drops.queue_full.events, sent);
  EXPECT_EQ(events_in_file(summary.run.events()).size(), summary.events);
  EXPECT_EQ(read_json(summary.run.info()).at("dropped").at("by_reason").at("queue_full").at("packets"),
            summary.drops.queue_full.packets);
}

TEST_F(RunRecorderTest, CountsWhatTheSourceLostDuringTheRunOnly) {
  const std::vector<events::Event> events = test::steady_events(1000, 0, 10, recorder_sensor);
  class Losing : public MadeSource {
   public:
    using MadeSource::MadeSource;
    Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
      lost.packets += 2;
      lost.events += 5;
      return MadeSource::receive(packet, patience);
    }
  };
  auto source =
      std::make_unique<Losing>("made:losing", std::vector{event_stream()}, test::packets_of_events(events, 100, true), false);
  source->lost.packets = source->lost.events = 1000;
  RunRecorder recorder(sources_of(std::move(source)), nullptr, nullptr);
  const RunSummary summary = record(recorder);
  EXPECT_EQ(summary.drops.source.packets, 22U);  // ten packets and the end
  EXPECT_EQ(summary.drops.source.events, 55U);
}

TEST_F(RunRecorderTest, CountsWhatTheSourceLostThoughNothingGoodFollows) {
  class Broken : public MadeSource {
   public:
    using MadeSource::MadeSource;
    Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
      if (lost.packets == 0)
        lost = {.packets = 7, .events = 5, .others = 4, .back_in_time = {.packets = 1, .events = 2, .others = 3}};
      return MadeSource::receive(packet, patience);
    }
  };
  RunRecorder recorder(sources_of(std::make_unique<Broken>(
                           "made:broken", std::vector{event_stream()},
                           [](CameraPacket&, std::chrono::milliseconds patience) { return MadeSource::silent_for(patience); })),
                       nullptr, nullptr);
  const RunFolder run = make_run_folder(data.path(), "fan");
  recorder.begin({.run = run, .session = "", .duration = {}});
  EXPECT_TRUE(test::comes_true([&] { return recorder.state().drops.source.packets > 0; }));
  const RunSummary summary = recorder.end("interrupted");
  EXPECT_EQ(summary.drops.source, (LostElements{.packets = 6, .events = 3, .others = 1}));
  EXPECT_EQ(summary.drops.back_in_time, (LostElements{.packets = 1, .events = 2, .others = 3}));
  EXPECT_EQ(read_json(run.info()).at("dropped").at("packets"), 7);
}

/// A recording that outgrows what it may take: one clear line, and what is written stays readable.
void expect_a_kept_beginning(const RunSummary& summary, std::uint64_t sent) {
  EXPECT_FALSE(summary.complete);
  ASSERT_FALSE(summary.errors.empty());
  EXPECT_NE(summary.ended.find("events.aedat4: cannot be written"), std::string::npos) << summary.ended;
  EXPECT_EQ(read_run_info(summary.run).complete, false);
  const std::vector<events::Event> kept = events_in_file(summary.run.events());
  EXPECT_GT(kept.size(), 8192U);
  EXPECT_LT(kept.size(), sent);
  for (std::size_t i = 0; i < kept.size(); ++i) ASSERT_EQ(us_of(kept[i].t), static_cast<std::int64_t>(i) + 1);
  EXPECT_EQ(summary.events, kept.size());
  EXPECT_EQ((summary.events + summary.drops.unwritten.events) % 5000, 0U) << "of each packet that came all is counted";
  EXPECT_EQ(summary.span, between(kept.front().t, kept.back().t));
  EXPECT_EQ(read_json(summary.run.info()).at("ended"), summary.ended) << "there was room for it";
}

TEST_F(RunRecorderTest, KeepsWhatFitsIfTheFileMayNotGrow) {
  std::atomic<std::uint64_t> sent{0};
  RunSummary summary;
  {
    const test::FileSizeLimit small(1'000'000);
    RunRecorder recorder(sources_of(event_source(noise(160, sent, 5000), false)), nullptr, nullptr,
                         {.compression = events::Compression::none});
    summary = record(recorder);
  }
  expect_a_kept_beginning(summary, std::uint64_t{100} * 8192);
  EXPECT_GT(summary.drops.unwritten.events, 0U);
}

TEST_F(RunRecorderTest, KeepsWhatFitsOnAFullDisk) {
  const fs::path disk = data / "disk";
  fs::create_directories(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=1m") != 0) GTEST_SKIP() << "NOT TESTED: no small disk can be mounted here";
  RunSummary summary;
  std::atomic<std::uint64_t> sent{0};
  {
    const test::FileSizeLimit small(1'000'000);
    RunRecorder recorder(sources_of(event_source(noise(160, sent, 5000), false)), nullptr, nullptr,
                         {.compression = events::Compression::none});
    recorder.begin({.run = make_run_folder(disk, "fan"), .session = "", .duration = {}});
    EXPECT_TRUE(test::comes_true([&] { return !recorder.state().ended.empty(); }));
    summary = recorder.end(recorder.state().ended);
  }
  expect_a_kept_beginning(summary, std::uint64_t{100} * 8192);
  EXPECT_EQ(::umount(disk.c_str()), 0);
}

std::size_t resident_bytes() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST_F(RunRecorderTest, DoesNotGrowOverALongReplay) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer keeps freed memory";
#endif
  constexpr std::size_t packets = 6000, packet_events = 8192;
  const std::vector<events::Event> pattern = test::steady_events(packet_events, 0, 0, recorder_sensor);
  std::atomic<std::size_t> early{0}, late{0};
  auto replay = [&, k = std::size_t{0}](CameraPacket& packet, std::chrono::milliseconds) mutable {
    if (k == packets / 4) early = resident_bytes();
    if (k == packets) late = resident_bytes();
    if (k == packets) return CameraSource::Received::ended;
    packet.stream_id = 0;
    packet.events = pattern;
    for (events::Event& event : packet.events) event.t = camera_time(static_cast<std::int64_t>(1000 * k));
    ++k;
    return CameraSource::Received::packet;
  };
  RunRecorder recorder(sources_of(event_source(replay, false)), nullptr, nullptr, {.queue_bytes = std::size_t{16} << 20});
  const RunSummary summary = record(recorder);
  EXPECT_EQ(summary.events, packets * packet_events);
  EXPECT_LT(late, early + (std::size_t{24} << 20))
      << "75 % of " << packets * packet_events * sizeof(events::Event) << " bytes came in between";
}

}  // namespace
}  // namespace tactile::capture
