#include "tactile/detect/event_feed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "support/comes_true.hpp"
#include "tactile/capture/camera_streams.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/detect/recorded_copy.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"

namespace tactile::detect {
namespace {

using test::comes_true;

/// A camera that sends what it is given, then ends or breaks.
class MadeSource final : public capture::CameraSource {
 public:
  static inline std::atomic<int> open_ones = 0;

  explicit MadeSource(std::vector<std::int64_t> times, std::string breaks = {})
      : stream_(events::event_stream_declaration({50, 50}, "MADE")),
        times_(times.begin(), times.end()),
        breaks_(std::move(breaks)) {
    ++open_ones;
  }
  ~MadeSource() override { --open_ones; }
  MadeSource(const MadeSource&) = delete;
  MadeSource& operator=(const MadeSource&) = delete;

  std::string name() const override { return "made"; }
  std::span<const events::Stream> streams() const override { return {&stream_, 1}; }
  nlohmann::json camera() const override { return nlohmann::json::object(); }
  Received receive(capture::CameraPacket& packet, std::chrono::microseconds) override {
    if (times_.empty()) {
      if (!breaks_.empty()) throw Error(breaks_);
      return Received::ended;
    }
    events::Event event;
    event.t = camera_time(times_.front());
    times_.pop_front();
    packet.events.push_back(event);
    times_kept_.keep(packet, name(), drops_);  // which throws where the clock was set back, as every live source does
    return Received::packet;
  }
  capture::SourceDrops drops() const override { return drops_; }

 private:
  events::Stream stream_;
  std::deque<std::int64_t> times_;
  std::string breaks_;
  capture::AscendingTimes times_kept_;
  capture::SourceDrops drops_;
};

struct Faults {
  std::mutex guard;
  std::vector<DetectionFault> all;
  ReportFault report() {
    return [this](const DetectionFault& fault) {
      const std::scoped_lock lock(guard);
      all.push_back(fault);
    };
  }
  std::string kinds() {
    const std::scoped_lock lock(guard);
    std::string kinds;
    for (const DetectionFault& fault : all) kinds += fault.kind + " ";
    return kinds;
  }
};

struct Taken {
  std::size_t source_index;
  std::vector<std::int64_t> times;
};

std::vector<Taken> all_of(EventFeed& feed) {
  std::vector<Taken> taken;
  capture::PacketQueue::Packet packet;
  while (feed.next(packet, std::chrono::seconds(60), {}) && !packet.empty()) {
    Taken& one = taken.emplace_back(Taken{packet.front().source_index, {}});
    for (const events::Event& event : packet.front().elements.events) one.times.push_back(us_of(event.t));
    feed.give_back(std::exchange(packet, {}));
  }
  return taken;
}

/// Received ahead by a thread of the feed's own, or by whoever takes the packets.
class EventFeedBothWays : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(ReceivedBy, EventFeedBothWays, testing::Values(true, false),
                         [](const auto& instance) { return instance.param ? "AThreadOfItsOwn" : "WhoeverTakes"; });

TEST_P(EventFeedBothWays, ReceivesAllPacketsAndEndsWithTheSource) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1, 2, 3}), queue,
                 {.receives_ahead = GetParam(), .fault = faults.report()});
  feed.start();
  EXPECT_EQ(all_of(feed).size(), 3U);
  EXPECT_EQ(feed.error(), "");
  EXPECT_EQ(faults.kinds(), "");
}

TEST_P(EventFeedBothWays, ReopensAStreamWhoseClockOf31BitsStartedAgain) {
  constexpr std::int64_t end = std::int64_t{1} << 31;
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  int opened = 0;
  EventFeedOptions options;
  options.receives_ahead = GetParam();
  options.fault = faults.report();
  options.waits = true;
  options.reconnect = std::chrono::seconds(60);
  options.open = [&]() -> std::unique_ptr<capture::CameraSource> {
    EXPECT_EQ(MadeSource::open_ones, 0) << "a camera opens but once";
    if (++opened == 1) throw Error("nobody is there yet");
    return std::make_unique<MadeSource>(std::vector<std::int64_t>{500, 1'000});
  };
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{end - 1'000, end - 500, 0, 500}), queue, options);
  feed.start();
  std::vector<Taken> taken;
  std::thread taking([&] { taken = all_of(feed); });
  taking.join();
  feed.stop();
  EXPECT_EQ(faults.kinds(), "broken back ");
  EXPECT_NE(faults.all[0].text.find("its time went back by 2147.483 s"), std::string::npos) << faults.all[0].text;
  ASSERT_GE(taken.size(), 5U);
  EXPECT_EQ(taken[1].times, (std::vector<std::int64_t>{end - 500}));
  EXPECT_EQ(taken[2].source_index, 1U) << "an empty packet: the source is gone";
  EXPECT_TRUE(taken[2].times.empty());
  // Whoever receives himself learns from another empty packet that it is back.
  const auto back = std::find_if(taken.begin() + 3, taken.end(), [](const Taken& one) { return !one.times.empty(); });
  ASSERT_NE(back, taken.end());
  EXPECT_EQ(back->source_index, 2U);
  EXPECT_EQ(back->times, (std::vector<std::int64_t>{500}));
  EXPECT_EQ(feed.reopened(), 1U);
}

/// Options of a feed that must not open its source again, and why not.
EventFeedOptions opening_nothing(bool receives_ahead, Faults& faults, std::chrono::seconds reconnect, const char* why) {
  EventFeedOptions options;
  options.receives_ahead = receives_ahead;
  options.fault = faults.report();
  options.reconnect = reconnect;
  options.open = [why]() -> std::unique_ptr<capture::CameraSource> {
    ADD_FAILURE() << why;
    throw Error("the source was opened");
  };
  return options;
}

TEST_P(EventFeedBothWays, DoesNotReopenASourceThatHasEnded) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  const EventFeedOptions options = opening_nothing(GetParam(), faults, std::chrono::seconds(600), "it had ended");
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1, 2}), queue, options);
  feed.start();
  EXPECT_EQ(all_of(feed).size(), 2U);
  EXPECT_EQ(feed.error(), "");
  EXPECT_EQ(faults.kinds(), "");
  EXPECT_FALSE(feed.gave_up_after());
}

TEST_P(EventFeedBothWays, ReportsWhyASourceIsLostThatCannotBeReopened) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}, "made: garbage; expected events"), queue,
                 {.receives_ahead = GetParam(), .fault = faults.report()});
  feed.start();
  all_of(feed);
  EXPECT_TRUE(comes_true([&] { return feed.error() == "made: garbage; expected events"; }));
  EXPECT_FALSE(feed.gave_up_after()) << "nothing was tried";
  EXPECT_EQ(faults.kinds(), "broken ");
}

TEST_P(EventFeedBothWays, DoesNotTryToReopenASourceForNoTime) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  const EventFeedOptions options = opening_nothing(GetParam(), faults, std::chrono::seconds(0), "there is no time for it");
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}, "made: broke"), queue, options);
  feed.start();
  all_of(feed);
  EXPECT_TRUE(comes_true([&] { return feed.error() == "made: broke"; }));
  EXPECT_FALSE(feed.gave_up_after());
  EXPECT_EQ(faults.kinds(), "broken ");
  EXPECT_EQ(faults.all.at(0).text, "made: broke");
}

TEST_P(EventFeedBothWays, GivesUpAfterAWhile) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeedOptions options;
  options.receives_ahead = GetParam();
  options.fault = faults.report();
  options.reconnect = std::chrono::milliseconds(120);
  options.open = []() -> std::unique_ptr<capture::CameraSource> { throw Error("nobody is there"); };
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}, "made: broke"), queue, options);
  feed.start();
  all_of(feed);
  EXPECT_TRUE(comes_true([&] { return feed.error() == "made: broke"; }));
  EXPECT_EQ(faults.kinds(), "broken gave up ");
  EXPECT_NE(faults.all.back().text.find("(nobody is there)"), std::string::npos) << faults.all.back().text;
  ASSERT_TRUE(feed.gave_up_after());
  EXPECT_GE(*feed.gave_up_after(), 120ms);
}

TEST(EventFeed, CountsPacketsWithoutRoom) {
  capture::PacketQueue queue(1);  // one packet at a time
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 50; ++t) times.push_back(t);
  EventFeed feed(std::make_unique<MadeSource>(times), queue, {});
  feed.start();
  EXPECT_TRUE(comes_true([&] { return !queue.is_open(); }));
  EXPECT_EQ(feed.lost_events() + all_of(feed).size(), 50U);
  EXPECT_GT(feed.lost_events(), 0U);
}

TEST(EventFeed, WaitsForRoomOnRequest) {
  capture::PacketQueue queue(1);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 50; ++t) times.push_back(t);
  EventFeed feed(std::make_unique<MadeSource>(times), queue, {.waits = true});
  feed.start();
  EXPECT_EQ(all_of(feed).size(), 50U);
  EXPECT_EQ(feed.lost_events(), 0U);
}

TEST(EventFeed, RestsBeforeItWaits) {
  capture::PacketQueue queue(std::size_t{1} << 20);
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}), queue, {.receives_ahead = false});
  feed.start();
  capture::PacketQueue::Packet packet;
  const HostTime begun = host_now();
  ASSERT_TRUE(feed.next(packet, 1s, 20ms));
  EXPECT_GE(host_now() - begun, 20ms) << "the packet was there all the time";
  ASSERT_FALSE(packet.empty());
  EXPECT_GE(packet.front().arrived, begun + 20ms) << "for lack of anything better, when it was received";
}

TEST(EventFeed, KnowsArrivalTimesEvenIfPacketsAreTakenLate) {
  transport::NetworkAddress any_port;
  any_port.host = "127.0.0.1";
  transport::DvStreamServer server(any_port, events::event_stream_declaration({50, 50}, "MADE"));
  std::atomic<bool> is_over{false};
  std::thread sending([&] {
    events::Event event;
    for (std::int64_t t = 0; !is_over; t += 1'000) {
      event.t = camera_time(t);
      server.send(std::span(&event, 1));
      std::this_thread::sleep_for(1ms);
    }
  });
  capture::PacketQueue queue(std::size_t{1} << 20);
  std::unique_ptr<capture::CameraSource> source = capture::open_camera_source(server.address().text());
  EXPECT_TRUE(source->reports_arrivals());
  EventFeed feed(std::move(source), queue, {.receives_ahead = false});
  feed.start();
  capture::PacketQueue::Packet packet;
  // The system may take a while until it notes when bytes arrive.
  EXPECT_TRUE(comes_true([&] {
    if (!feed.next(packet, 1s, 50ms) || packet.empty()) return false;
    const bool is_known = host_now() - packet.front().arrived >= 20ms;
    feed.give_back(std::exchange(packet, {}));
    return is_known;
  }));
  is_over = true;
  sending.join();
}

TEST(RecordedCopy, EndsWhenTheCamerasClockStartsAgain) {
  MadeSource source({});
  RecordedCopy copy(source, false);
  capture::CameraPacket packet;
  packet.events.resize(1);
  packet.events[0].t = camera_time(1'000);
  copy.put(packet);
  packet.events[0].t = camera_time(10);
  copy.put(packet);
  copy.put(packet);
  EXPECT_TRUE(copy.ended_early());
  capture::CameraPacket got;
  ASSERT_EQ(copy.receive(got, std::chrono::milliseconds(1)), capture::CameraSource::Received::packet);
  EXPECT_EQ(got.events.front().t, camera_time(1'000));
  EXPECT_EQ(copy.receive(got, std::chrono::milliseconds(1)), capture::CameraSource::Received::ended);
}

}  // namespace
}  // namespace tactile::detect
