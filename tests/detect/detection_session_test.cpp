#include "tactile/detect/detection_session.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "detect/live.hpp"
#include "events/made_recording.hpp"
#include "support/error_of.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"

namespace tactile::detect {
namespace {

using namespace test;

std::unique_ptr<model::EventClassifier> open_model(events::SensorSize of) {
  EXPECT_EQ(of, sensor);
  return model_of(slip_where_anything_is);
}

DetectionOptions options_for(const std::string& source) {
  DetectionOptions options;
  options.source = source;
  options.source_options.speed = 0;
  options.detector.rendering = short_history;
  return options;
}

std::string message_of(const std::exception_ptr& failure) {
  return test::error_of([&] {
    if (failure) std::rethrow_exception(failure);
  });
}

/// 50 ms of events, 50 ms of silence, 50 ms of events.
class DetectionSessionOfAFile : public testing::Test {
 protected:
  DetectionSessionOfAFile() {
    const std::vector<events::Event> later = test::steady_events(500, 100'000, 100, sensor);
    events.insert(events.end(), later.begin(), later.end());
    test::write_plain_recording(file, events, sensor);
  }
  static DetectionSummary detect(DetectionOptions options, const TickOutput& output = {}) {
    return DetectionSession(std::move(options), open_model).run(output);
  }

  test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "events.aedat4";
  std::vector<events::Event> events = test::steady_events(500, 0, 100, sensor);
  const std::string source = "file:" + file.string();
};

TEST_F(DetectionSessionOfAFile, ReportsEveryTickOnceAndCountsEpisodes) {
  std::vector<std::pair<CameraTime, std::uint64_t>> offline, live;
  heatmaps::for_every_tick(
      events, sensor, {.history = 10ms, .tick = 2ms},
      [&](CameraTime t, std::span<const std::uint8_t>, std::uint64_t count) { offline.emplace_back(t, count); });
  std::vector<CameraTime> begins, ends;
  bool has_ended = false;
  TickOutput output;
  output.episode = [&](const ReportedTick& tick) { begins.push_back(tick.verdict.t); };
  output.episode_end = [&](const VerdictEpisode& episode) {
    ASSERT_EQ(begins.size(), ends.size() + 1) << "each end comes before the next begin";
    EXPECT_EQ(episode.first, begins.back());
    ends.push_back(episode.last);
  };
  output.ticks = [&](std::span<const ReportedTick> ticks) {
    for (const ReportedTick& tick : ticks) live.emplace_back(tick.verdict.t, tick.verdict.events);
  };
  output.end = [&] { has_ended = true; };
  const DetectionSummary summary = detect(options_for(source), output);
  EXPECT_EQ(live, offline);
  EXPECT_TRUE(has_ended);
  EXPECT_EQ(begins, (std::vector{camera_time(10'000), camera_time(102'000)}));
  ASSERT_EQ(ends.size(), 2U) << "also of the one that lasts until the end";
  EXPECT_EQ(ends[0], camera_time(58'000));
  EXPECT_EQ(ends[1], live.back().first);
  EXPECT_EQ(summary.verdicts.episodes[static_cast<std::size_t>(Touch::slip)], 2U);
  EXPECT_EQ(summary.verdicts.first_episodes.at(0).last, camera_time(58'000)) << "the last history with an event";
  EXPECT_EQ(summary.deadlines.counts().reported, offline.size());
  EXPECT_EQ(summary.ended, "source ended");
  EXPECT_TRUE(summary.plays);
  EXPECT_FALSE(summary.used_real_time) << "a replay has no deadline";
  EXPECT_TRUE(summary.faults.empty());
  EXPECT_FALSE(summary.failure);
}

TEST_F(DetectionSessionOfAFile, EndsAfterItsDuration) {
  DetectionOptions options = options_for(source);
  options.duration = 20ms;
  const DetectionSummary summary = detect(options);
  EXPECT_EQ(summary.ended, "duration");
  EXPECT_EQ(summary.deadlines.counts().reported, 10U);
}

TEST_F(DetectionSessionOfAFile, EndsWithAnErrorOfTheOutput) {
  TickOutput output;
  output.ticks = [](const auto&) { throw Error("the disk is full"); };
  output.end = [] { ADD_FAILURE() << "the output has failed"; };
  const DetectionSummary summary = detect(options_for(source), output);
  EXPECT_EQ(summary.ended, "the disk is full");
  EXPECT_EQ(message_of(summary.failure), "the disk is full");
}

TEST_F(DetectionSessionOfAFile, CountsEventsThatCannotBeUsed) {
  const auto outside = static_cast<std::int16_t>(sensor.width);
  test::overwrite(file, test::event_offset(test::packets_of(file).front(), 5) + 8, outside);
  const DetectionSummary summary = detect(options_for(source));
  EXPECT_EQ(summary.drops.events, 1U);
  EXPECT_EQ(summary.counts.events, events.size() - 1);
}

TEST_F(DetectionSessionOfAFile, RecordsTheRun) {
  DetectionOptions options = options_for(source);
  options.record = SessionRecordingOptions{.data = folder / "data", .object = "cup"};
  const DetectionSummary summary = detect(options);
  ASSERT_TRUE(summary.recorded);
  EXPECT_TRUE(summary.recorded->complete);
  EXPECT_EQ(summary.recorded->ended, "source ended");
  EXPECT_EQ(test::events_in_file(folder / "data/cup/01/events.aedat4"), events);
}

TEST_F(DetectionSessionOfAFile, RefusesAModelOfAnotherSensor) {
  const OpenModel refuses = [](events::SensorSize of) -> std::unique_ptr<model::EventClassifier> {
    throw Error(fmt::format("a sensor of {} x {}", of.width, of.height));
  };
  EXPECT_EQ(test::error_of([&] { DetectionSession(options_for(source), refuses); }), "a sensor of 50 x 50");
}

transport::NetworkAddress any_free_port() {
  transport::NetworkAddress address;
  address.host = "127.0.0.1";
  return address;
}

/// A stream of an event each millisecond, as long as it lives.
class LiveStream {
 public:
  LiveStream() {
    thread_ = std::thread([this] {
      for (std::int64_t t = 0; !is_over_; t += 1'000) {
        const events::Event event = test::event_at(t, static_cast<int>(t / 1'000 % 50));
        server_->send(std::span(&event, 1));
        std::this_thread::sleep_for(1ms);
      }
    });
  }
  ~LiveStream() { close(); }
  LiveStream(const LiveStream&) = delete;
  LiveStream& operator=(const LiveStream&) = delete;

  void close() {
    is_over_ = true;
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }
  DetectionOptions options() const {
    DetectionOptions options = options_for(server_->address().text());
    options.source_options.speed = 1;
    options.real_time = false;
    return options;
  }

 private:
  std::unique_ptr<transport::DvStreamServer> server_ = std::make_unique<transport::DvStreamServer>(
      any_free_port(), events::event_stream_declaration(sensor, "DVXplorer_DXM00001"));
  std::atomic<bool> is_over_{false};
  std::thread thread_;
};

TEST(DetectionSession, StopsALiveStreamWhenTheCallerInterrupts) {
  LiveStream stream;
  std::uint64_t reported = 0;
  TickOutput output;
  output.ticks = [&](std::span<const ReportedTick> ticks) { reported += ticks.size(); };
  output.interrupted = [&] { return reported > 3; };
  DetectionSession session(stream.options(), open_model);
  const DetectionSummary summary = session.run(output);
  EXPECT_EQ(summary.ended, "interrupted");
  EXPECT_FALSE(summary.plays);
  EXPECT_FALSE(summary.failure);
  EXPECT_EQ(summary.deadlines.counts().reported, reported) << "the last ticks are passed on, too";
}

TEST(DetectionSession, EndsWithAStreamThatCloses) {
  LiveStream stream;
  std::uint64_t reported = 0;
  TickOutput output;
  output.ticks = [&](std::span<const ReportedTick> ticks) {
    reported += ticks.size();
    if (reported > 3) stream.close();
  };
  DetectionSession session(stream.options(), open_model);
  const DetectionSummary summary = session.run(output);
  EXPECT_EQ(summary.ended, "source ended");
  EXPECT_GT(summary.counts.events, 0U);
}

}  // namespace
}  // namespace tactile::detect
