#include "tactile/capture/run_recorder.hpp"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <memory>
#include <random>

#include "capture/made_source.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::event_at;
using test::events_in_file;
using test::MadeSource;

constexpr events::SensorSize size{640, 480};

events::Stream event_stream(const std::string& camera = "DVXplorer_DXM00001") {
  return events::event_stream_declaration(size, camera);
}

events::Stream imu_stream(std::int32_t id = 0, const std::string& camera = "DVXplorer_DXM00001") {
  return test::stream_of(id, events::StreamType::imu, "IMUS", camera);
}

std::vector<std::unique_ptr<CameraSource>> sources_of(auto... sources) {
  std::vector<std::unique_ptr<CameraSource>> all;
  (all.push_back(std::move(sources)), ...);
  return all;
}

std::unique_ptr<MadeSource> event_source(MadeSource::Step step, bool live = true) {
  return std::make_unique<MadeSource>("made:events", std::vector{event_stream()}, std::move(step), live);
}

class RunRecorderTest : public testing::Test {
 protected:
  /// Records until the recorder says that the run must end.
  RunSummary record(RunRecorder& recorder, std::optional<microseconds> duration = {}) {
    RunRequest request{.run = make_run_folder(data.path(), "fan"), .session = "monday", .duration = duration};
    request.settings = {{"asked", 1}};
    recorder.begin(request);
    RunState state;
    EXPECT_TRUE(test::comes_true([&] {
      state = recorder.state();
      return !state.ended.empty();
    }));
    return recorder.end(state.ended);
  }

  test::TemporaryFolder data;
};

TEST_F(RunRecorderTest, PutsAllStreamsOfACameraIntoOneRecording) {
  const std::vector<events::Event> events = test::steady_events(50'000, 1'000'000, 20, size);
  std::vector<events::ImuSample> samples;
  for (int i = 0; i < 100; ++i)
    samples.push_back({.t = camera_time(1'000'000 + 10'000 * i), .temperature_c = 20.0F + static_cast<float>(i)});
  auto imu = std::make_unique<MadeSource>("made:imu", std::vector{imu_stream(7)},
                                          [samples, sent = false](CameraPacket& packet, std::chrono::milliseconds) mutable {
                                            if (std::exchange(sent, true)) return CameraSource::Received::ended;
                                            packet.stream_id = 7;
                                            packet.imu = samples;
                                            return CameraSource::Received::packet;
                                          });
  RunRecorder recorder(sources_of(std::move(imu), event_source(test::packets_of_events(events, 777, true))), nullptr, nullptr);
  ASSERT_EQ(recorder.streams().size(), 2U);
  EXPECT_EQ(recorder.streams()[0].type, events::StreamType::events);
  EXPECT_EQ(recorder.streams()[1].type, events::StreamType::imu);
  EXPECT_EQ(recorder.streams()[1].id, 1);

  const RunSummary summary = record(recorder);
  EXPECT_EQ(summary.ended, "source ended");
  EXPECT_TRUE(summary.complete);
  EXPECT_TRUE(summary.errors.empty());
  EXPECT_EQ(summary.events, events.size());
  EXPECT_EQ(summary.others, samples.size());
  EXPECT_EQ(summary.span, between(events.front().t, events.back().t));
  EXPECT_EQ(events_in_file(summary.run.events()), events);
  events::RecordingReader recording(summary.run.events());
  EXPECT_EQ(recording.index(), events::PacketIndex::table);
  std::size_t read = 0;
  for (const events::PacketRecord& packet : recording.packets()) {
    EXPECT_LT(between(packet.first, packet.last), 10ms);
    if (packet.stream_id == 1) read += recording.read_imu(packet).size();
  }
  EXPECT_EQ(read, samples.size());

  const nlohmann::json run = read_json(summary.run.info());
  EXPECT_EQ(run.at("complete"), true);
  EXPECT_EQ(run.at("simulated"), false);
  EXPECT_EQ(run.at("session"), "monday");
  EXPECT_EQ(run.at("sensor").at("width"), 640);
  EXPECT_EQ(run.at("camera").at("readout_mode"), "made");
  EXPECT_EQ(run.at("sources").size(), 2U);
  EXPECT_EQ(run.at("settings").at("asked"), 1);
  EXPECT_EQ(run.at("ended"), "source ended");
  EXPECT_EQ(run.at("software").at("name"), "tactile");
  EXPECT_LE(run.at("host_time_us").at("begin"), run.at("host_time_us").at("end"));
  EXPECT_EQ(run.at("dropped").at("events"), 0);
  EXPECT_EQ(run.at("files").at("events.aedat4").at("sha256"), sha256_of_file(summary.run.events()));
  ASSERT_GE(run.at("host_from_camera").size(), 1U);
  EXPECT_EQ(run.at("host_from_camera").at(0).size(), 2U);
  EXPECT_EQ(read_run_info(summary.run).complete, true);
}

TEST_F(RunRecorderTest, ReportsThatItIsNotCompleteWhileItRecords) {
  const std::vector<events::Event> events = test::steady_events(1000, 0, 10, size);
  RunRecorder recorder(sources_of(event_source(test::packets_of_events(events, 100, false))), nullptr, nullptr);
  const RunFolder run = make_run_folder(data.path(), "fan");
  recorder.begin({.run = run, .session = "monday", .duration = {}});
  EXPECT_EQ(read_run_info(run).complete, false);
  EXPECT_EQ(read_run_info(run).session, "monday");
  // A camera that falls silent is no fault, and what it sent comes to the disk without any more.
  EXPECT_TRUE(test::comes_true([&] { return events_in_file(run.events()).size() == events.size(); }));
  EXPECT_EQ(recorder.state().ended, "");
  EXPECT_EQ(recorder.state().events, events.size());
  const RunSummary summary = recorder.end("interrupted");
  EXPECT_EQ(summary.ended, "interrupted");
  EXPECT_EQ(read_run_info(run).complete, true);
  EXPECT_EQ(events_in_file(run.events()), events);
}

TEST_F(RunRecorderTest, LeavesOutAndCountsWhatCannotBeWritten) {
  std::vector<events::Event> events = test::steady_events(1000, 100'000, 10, size);
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

/// Noise, so that the strongest compression takes its time.
MadeSource::Step noise(int packets, std::atomic<std::uint64_t>& sent, int packet_events = 8192) {
  return [packets, packet_events, &sent, random = std::mt19937(1), t = std::int64_t{0}](CameraPacket& packet,
                                                                                        std::chrono::milliseconds) mutable {
    if (packets-- == 0) return CameraSource::Received::ended;
    packet.stream_id = 0;
    for (int i = 0; i < packet_events; ++i)
      packet.events.push_back(
          event_at(++t, static_cast<int>(random() % 640), static_cast<int>(random() % 480), static_cast<int>(random() % 2)));
    sent += packet.events.size();
    return CameraSource::Received::packet;
  };
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

TEST_F(RunRecorderTest, LetsASourceWaitThatIsNotLive) {
  std::atomic<std::uint64_t> sent{0};
  RunRecorder recorder(sources_of(event_source(noise(40, sent), false)), nullptr, nullptr,
                       {.queue_bytes = 300'000, .compression = events::Compression::zstd_high});
  const RunSummary summary = record(recorder);
  EXPECT_EQ(summary.drops.total().events, 0U);
  EXPECT_EQ(summary.events, 40U * 8192U);
  EXPECT_EQ(events_in_file(summary.run.events()).size(), 40U * 8192U);
}

TEST_F(RunRecorderTest, CutsAReplayToItsDurationToTheMicrosecond) {
  const std::vector<events::Event> events = test::steady_events(10'000, 5'000, 100, size);
  RunRecorder recorder(sources_of(event_source(test::packets_of_events(events, 300, true), false)), nullptr, nullptr);
  const RunSummary summary = record(recorder, 50ms);
  EXPECT_EQ(summary.ended, "duration");
  EXPECT_EQ(events_in_file(summary.run.events()), std::vector<events::Event>(events.begin(), events.begin() + 500));
  EXPECT_EQ(summary.drops.total().events, 0U);
  EXPECT_TRUE(read_json(summary.run.info()).at("host_from_camera").empty()) << "nothing was live";
}

TEST_F(RunRecorderTest, SpansFromTheEarliestElementToTheLatest) {
  auto step = [next = 0](CameraPacket& packet, std::chrono::milliseconds) mutable {
    if (next == 2) return CameraSource::Received::ended;
    packet.stream_id = next;
    if (next++ == 0) {
      packet.events = {event_at(2'000), event_at(3'000)};
    } else {
      packet.imu = {{.t = camera_time(500)}, {.t = camera_time(2'500)}};
    }
    return CameraSource::Received::packet;
  };
  RunRecorder recorder(
      sources_of(std::make_unique<MadeSource>("made:both", std::vector{event_stream(), imu_stream(1)}, step, false)), nullptr,
      nullptr);
  EXPECT_EQ(record(recorder).span, 2'500us);
}

TEST_F(RunRecorderTest, EndsALiveRunByTheHostsClock) {
  RunRecorder recorder(sources_of(event_source(
                           [](CameraPacket&, std::chrono::milliseconds patience) { return MadeSource::silent_for(patience); })),
                       nullptr, nullptr);
  const RunSummary summary = record(recorder, 100ms);
  EXPECT_EQ(summary.ended, "duration");
  EXPECT_GE(summary.elapsed, 100ms);
  EXPECT_TRUE(summary.complete);
  EXPECT_EQ(summary.events, 0U);
}

TEST_F(RunRecorderTest, KeepsWhatCameBeforeTheSourceWasGone) {
  const std::vector<events::Event> events = test::steady_events(5000, 0, 10, size);
  auto gone = [sent = false, events](CameraPacket& packet, std::chrono::milliseconds) mutable -> CameraSource::Received {
    if (sent) throw Error("tcp://127.0.0.1:7777: the stream ends inside a packet; expected it whole");
    sent = true;
    packet.stream_id = 0;
    packet.events = events;
    return CameraSource::Received::packet;
  };
  RunRecorder recorder(sources_of(event_source(gone)), nullptr, nullptr);
  const RunSummary summary = record(recorder);
  EXPECT_EQ(summary.ended, "source gone: tcp://127.0.0.1:7777: the stream ends inside a packet; expected it whole");
  EXPECT_EQ(summary.errors, std::vector<std::string>{summary.ended});
  EXPECT_TRUE(summary.complete);
  EXPECT_EQ(events_in_file(summary.run.events()), events);
  EXPECT_EQ(read_json(summary.run.info()).at("ended"), summary.ended);
  EXPECT_EQ(recorder.gone(), summary.ended);
}

TEST_F(RunRecorderTest, RecordsRunAfterRunAndDiscardsWhatComesInBetween) {
  std::atomic<std::int64_t> newest{0};
  auto steady = [&newest](CameraPacket& packet, std::chrono::milliseconds) {
    packet.stream_id = 0;
    for (int i = 0; i < 100; ++i) packet.events.push_back(event_at(++newest));
    std::this_thread::sleep_for(100us);
    return CameraSource::Received::packet;
  };
  RunRecorder recorder(sources_of(event_source(steady)), nullptr, nullptr);
  recorder.discard();
  std::vector<std::vector<events::Event>> runs;
  for (int k = 0; k < 3; ++k) {
    const std::int64_t before = newest;
    ASSERT_TRUE(test::comes_true([&] { return newest > before + 1000; }));
    const RunFolder run = make_run_folder(data.path(), "fan");
    recorder.begin({.run = run, .session = "monday", .duration = {}});
    ASSERT_TRUE(test::comes_true([&] { return recorder.state().events > 2000; }));
    const RunSummary summary = recorder.end("interrupted");
    EXPECT_EQ(summary.drops.total().events, 0U);
    runs.push_back(events_in_file(run.events()));
    ASSERT_EQ(runs.back().size(), summary.events);
    EXPECT_EQ(us_of(runs.back().back().t) - us_of(runs.back().front().t) + 1, static_cast<std::int64_t>(summary.events))
        << "a hole";
    EXPECT_GT(us_of(runs.back().front().t), before + 500);
  }
}

TEST_F(RunRecorderTest, ShowsTheEventsOfItsFirstStreamAlsoBetweenRuns) {
  std::atomic<std::int64_t> newest{0}, seen{0};
  auto steady = [&newest](CameraPacket& packet, std::chrono::milliseconds) {
    packet.stream_id = 0;
    packet.events.push_back(event_at(++newest));
    std::this_thread::sleep_for(100us);
    return CameraSource::Received::packet;
  };
  auto silent = [](CameraPacket&, std::chrono::milliseconds patience) { return MadeSource::silent_for(patience); };
  RunRecorderOptions options;
  options.see_events = [&seen](std::span<const events::Event> events) {
    for (const events::Event& event : events) seen = us_of(event.t);
  };
  RunRecorder recorder(
      sources_of(event_source(steady), std::make_unique<MadeSource>("made:imu", std::vector{imu_stream()}, silent)), nullptr,
      nullptr, std::move(options));
  recorder.discard();
  ASSERT_TRUE(test::comes_true([&] { return seen > 10; })) << "no run has begun";
  recorder.begin({.run = make_run_folder(data.path(), "fan"), .session = "monday", .duration = {}});
  const std::int64_t before = newest;
  ASSERT_TRUE(test::comes_true([&] { return seen > before + 10; }));
  recorder.end("interrupted");
  const std::vector<SourceState> sources = recorder.sources();
  ASSERT_EQ(sources.size(), 2U);
  EXPECT_EQ(sources[0].name, "made:events");
  EXPECT_GT(sources[0].packets, 20U);
  EXPECT_EQ(sources[1].packets, 0U) << "the IMU is silent";
  EXPECT_FALSE(sources[1].has_ended);
}

TEST_F(RunRecorderTest, RefusesTheSameStreamTwiceAndSourcesWithoutEvents) {
  const auto silent = [](CameraPacket&, std::chrono::milliseconds patience) { return MadeSource::silent_for(patience); };
  EXPECT_THROW(RunRecorder(sources_of(event_source(silent), event_source(silent)), nullptr, nullptr), Error);
  EXPECT_THROW(
      RunRecorder(sources_of(std::make_unique<MadeSource>("made:imu", std::vector{imu_stream()}, silent)), nullptr, nullptr),
      Error);
  EXPECT_THROW(RunRecorder({}, nullptr, nullptr), Error);
}

TEST_F(RunRecorderTest, MarksSimulatedStreams) {
  events::Stream stream = event_stream();
  stream.info.emplace_back("simulated", "true");
  RunRecorder recorder(
      sources_of(std::make_unique<MadeSource>("made:sim", std::vector{stream}, test::packets_of_events({event_at(1)}, 1, true))),
      nullptr, nullptr);
  const RunSummary summary = record(recorder);
  EXPECT_TRUE(summary.simulated);
  EXPECT_TRUE(read_run_info(summary.run).simulated);
}

TEST_F(RunRecorderTest, NeverTouchesAFolderThatHoldsSomething) {
  const RunFolder run = make_run_folder(data.path(), "fan");
  write_whole(run.events(), "precious");
  RunRecorder recorder(sources_of(event_source(test::packets_of_events({event_at(1)}, 1, true))), nullptr, nullptr);
  EXPECT_THROW(recorder.begin({.run = run, .session = "", .duration = {}}), Error);
  EXPECT_EQ(read_text(run.events()), "precious");
}

TEST_F(RunRecorderTest, CountsWhatTheSourceLostDuringTheRunOnly) {
  const std::vector<events::Event> events = test::steady_events(1000, 0, 10, size);
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

TEST_F(RunRecorderTest, BeginsOnceTheSourcesAreReady) {
  class Slow : public MadeSource {
   public:
    using MadeSource::MadeSource;
    void begin_run(const RunFolder& /*run*/) override {
      std::this_thread::sleep_for(50ms);
      ready = us_of(host_now());
    }
    std::atomic<std::int64_t> ready{0};
  };
  auto source =
      std::make_unique<Slow>("made:slow", std::vector{event_stream()}, test::packets_of_events({event_at(1)}, 1, false));
  const Slow& slow = *source;
  RunRecorder recorder(sources_of(std::move(source)), nullptr, nullptr);
  const RunSummary summary = record(recorder, 10ms);
  EXPECT_GE(read_json(summary.run.info()).at("host_time_us").at("begin").get<std::int64_t>(), slow.ready);
}

TEST_F(RunRecorderTest, ReportsOnceAStreamThatEndsWhileEventsContinue) {
  auto imu = std::make_unique<MadeSource>("made:imu", std::vector{imu_stream()},
                                          [](CameraPacket&, std::chrono::milliseconds) { return CameraSource::Received::ended; });
  const auto silent = [](CameraPacket&, std::chrono::milliseconds patience) { return MadeSource::silent_for(patience); };
  std::vector<std::string> told;
  RunRecorder recorder(sources_of(event_source(silent), std::move(imu)), nullptr, nullptr,
                       {.log = [&](const std::string& text) { told.push_back(text); }});
  const RunFolder run = make_run_folder(data.path(), "fan");
  recorder.begin({.run = run, .session = "", .duration = {}});
  EXPECT_TRUE(test::comes_true([&] { return recorder.state().ended.empty() && !told.empty(); }));
  EXPECT_EQ(recorder.state().ended, "");
  recorder.end("interrupted");
  EXPECT_EQ(told, std::vector<std::string>{"made:imu: has ended, and the run continues without it"});
  const nlohmann::json sources = read_json(run.info()).at("sources");
  EXPECT_TRUE(sources.at(0).at("ended").is_null());
  EXPECT_TRUE(sources.at(1).at("ended").is_number_integer());
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
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_action = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{.rlim_cur = 1'000'000, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::atomic<std::uint64_t> sent{0};
  RunSummary summary;
  {
    RunRecorder recorder(sources_of(event_source(noise(160, sent, 5000), false)), nullptr, nullptr,
                         {.compression = events::Compression::none});
    summary = record(recorder);
  }
  EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, old_action);
  expect_a_kept_beginning(summary, 100 * 8192);
  EXPECT_GT(summary.drops.unwritten.events, 0U);
}

TEST_F(RunRecorderTest, KeepsWhatFitsOnAFullDisk) {
  const fs::path disk = data / "disk";
  fs::create_directories(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=1m") != 0) GTEST_SKIP() << "NOT TESTED: no small disk can be mounted here";
  RunSummary summary;
  std::atomic<std::uint64_t> sent{0};
  {
    RunRecorder recorder(sources_of(event_source(noise(160, sent, 5000), false)), nullptr, nullptr,
                         {.compression = events::Compression::none});
    recorder.begin({.run = make_run_folder(disk, "fan"), .session = "", .duration = {}});
    EXPECT_TRUE(test::comes_true([&] { return !recorder.state().ended.empty(); }));
    summary = recorder.end(recorder.state().ended);
  }
  expect_a_kept_beginning(summary, 100 * 8192);
  EXPECT_EQ(::umount(disk.c_str()), 0);
}

std::size_t resident_bytes() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST_F(RunRecorderTest, DoesNotGrowOverALongReplay) {
  constexpr std::size_t packets = 6000, packet_events = 8192;
  const std::vector<events::Event> pattern = test::steady_events(packet_events, 0, 0, size);
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
