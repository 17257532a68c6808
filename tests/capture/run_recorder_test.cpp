#include "tactile/capture/run_recorder.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "capture/recorded_run.hpp"
#include "support/events_in_file.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::capture {
namespace {

using namespace std::chrono_literals;
using test::event_at;
using test::event_source;
using test::event_stream;
using test::events_in_file;
using test::imu_stream;
using test::MadeSource;
using test::noise;
using test::recorder_sensor;
using test::RunRecorderTest;
using test::sources_of;

TEST_F(RunRecorderTest, PutsAllStreamsOfACameraIntoOneRecording) {
  const std::vector<events::Event> events = test::steady_events(50'000, 1'000'000, 20, recorder_sensor);
  std::vector<events::ImuSample> samples;
  samples.reserve(100);
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
  const std::vector<events::Event> events = test::steady_events(1000, 0, 10, recorder_sensor);
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
  const std::vector<events::Event> events = test::steady_events(10'000, 5'000, 100, recorder_sensor);
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
  const std::vector<events::Event> events = test::steady_events(5000, 0, 10, recorder_sensor);
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
  std::vector<std::string> logged;
  RunRecorder recorder(sources_of(event_source(silent), std::move(imu)), nullptr, nullptr,
                       {.log = [&](const std::string& text) { logged.push_back(text); }});
  const RunFolder run = make_run_folder(data.path(), "fan");
  recorder.begin({.run = run, .session = "", .duration = {}});
  EXPECT_TRUE(test::comes_true([&] { return recorder.state().ended.empty() && !logged.empty(); }));
  EXPECT_EQ(recorder.state().ended, "");
  recorder.end("interrupted");
  EXPECT_EQ(logged, std::vector<std::string>{"made:imu: has ended, and the run continues without it"});
  const nlohmann::json sources = read_json(run.info()).at("sources");
  EXPECT_TRUE(sources.at(0).at("ended").is_null());
  EXPECT_TRUE(sources.at(1).at("ended").is_number_integer());
}

}  // namespace
}  // namespace tactile::capture
