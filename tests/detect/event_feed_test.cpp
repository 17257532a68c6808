#include "tactile/detect/event_feed.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <mutex>

#include "support/comes_true.hpp"
#include "tactile/capture/camera_streams.hpp"
#include "tactile/core/error.hpp"
#include "tactile/detect/recorded_copy.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace {

using test::comes_true;

/// A camera that sends what it is given, then ends or breaks.
class MadeSource final : public CameraSource {
 public:
  explicit MadeSource(std::vector<std::int64_t> times, std::string breaks = {})
      : stream_(event_stream_declaration({50, 50}, "MADE")), times_(times.begin(), times.end()), breaks_(std::move(breaks)) {}

  std::string name() const override { return "made"; }
  std::span<const Stream> streams() const override { return {&stream_, 1}; }
  nlohmann::json camera() const override { return nlohmann::json::object(); }
  Received receive(CameraPacket& packet, std::chrono::milliseconds) override {
    if (times_.empty()) {
      if (!breaks_.empty()) throw Error(breaks_);
      return Received::ended;
    }
    Event event;
    event.t = camera_time(times_.front());
    times_.pop_front();
    packet.events.push_back(event);
    times_kept_.keep(packet, name(), drops_);  // which throws where the clock was set back, as every live source does
    return Received::packet;
  }
  SourceDrops drops() const override { return drops_; }

 private:
  Stream stream_;
  std::deque<std::int64_t> times_;
  std::string breaks_;
  AscendingTimes times_kept_;
  SourceDrops drops_;
};

struct Faults {
  std::mutex guard;
  std::vector<DetectionFault> all;
  TellFault tell() {
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

std::vector<Taken> all_of(PacketQueue& queue) {
  std::vector<Taken> taken;
  PacketQueue::Packet packet;
  while (queue.pop(packet, std::chrono::seconds(60)) && !packet.empty()) {
    Taken& one = taken.emplace_back(Taken{packet.front().source_index, {}});
    for (const Event& event : packet.front().elements.events) one.times.push_back(us_of(event.t));
    queue.give_back(std::exchange(packet, {}));
  }
  return taken;
}

TEST(EventFeed, BringsWhatASourceSendsAndEndsWithIt) {
  PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1, 2, 3}), queue, {.fault = faults.tell()});
  feed.start();
  EXPECT_EQ(all_of(queue).size(), 3U);
  EXPECT_EQ(feed.error(), "");
  EXPECT_EQ(faults.kinds(), "");
}

TEST(EventFeed, OpensAnewAStreamWhoseClockOf31BitsBeganAgain) {
  constexpr std::int64_t end = std::int64_t{1} << 31;
  PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  int opened = 0;
  EventFeedOptions options;
  options.fault = faults.tell();
  options.waits = true;
  options.reconnect = std::chrono::seconds(60);
  options.open = [&]() -> std::unique_ptr<CameraSource> {
    if (++opened == 1) throw Error("nobody is there yet");
    if (opened > 2) throw Error("gone for good");
    return std::make_unique<MadeSource>(std::vector<std::int64_t>{500, 1'000});
  };
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{end - 1'000, end - 500, 0, 500}), queue, options);
  feed.start();
  EXPECT_TRUE(comes_true([&] { return faults.kinds().find("closed") != std::string::npos; })) << faults.kinds();
  feed.stop();
  const std::vector<Taken> taken = all_of(queue);
  EXPECT_EQ(faults.kinds(), "broken back closed ");
  EXPECT_NE(faults.all[0].text.find("its time went back by 2147.483 s"), std::string::npos) << faults.all[0].text;
  ASSERT_GE(taken.size(), 5U);
  EXPECT_EQ(taken[1].times, (std::vector<std::int64_t>{end - 500}));
  EXPECT_EQ(taken[2].source_index, 1U) << "an empty packet: the source is gone";
  EXPECT_TRUE(taken[2].times.empty());
  EXPECT_EQ(taken[3].source_index, 2U);
  EXPECT_EQ(taken[3].times, (std::vector<std::int64_t>{500}));
  EXPECT_EQ(feed.reopened(), 1U);
}

TEST(EventFeed, SaysWhyASourceIsGoneThatCannotBeOpenedAgain) {
  PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}, "made: garbage; expected events"), queue,
                 {.fault = faults.tell()});
  feed.start();
  all_of(queue);
  EXPECT_TRUE(comes_true([&] { return feed.error() == "made: garbage; expected events"; }));
  EXPECT_FALSE(feed.gave_up_after()) << "nothing was tried";
  EXPECT_EQ(faults.kinds(), "broken ");
}

TEST(EventFeed, GivesUpAfterAWhile) {
  PacketQueue queue(std::size_t{1} << 20);
  Faults faults;
  EventFeedOptions options;
  options.fault = faults.tell();
  options.reconnect = std::chrono::milliseconds(120);
  options.open = []() -> std::unique_ptr<CameraSource> { throw Error("nobody is there"); };
  EventFeed feed(std::make_unique<MadeSource>(std::vector<std::int64_t>{1}, "made: broke"), queue, options);
  feed.start();
  all_of(queue);
  EXPECT_TRUE(comes_true([&] { return feed.error() == "made: broke"; }));
  EXPECT_EQ(faults.kinds(), "broken gave up ");
  EXPECT_NE(faults.all.back().text.find("(nobody is there)"), std::string::npos) << faults.all.back().text;
  ASSERT_TRUE(feed.gave_up_after());
  EXPECT_GE(*feed.gave_up_after(), 120ms);
}

TEST(EventFeed, CountsWhatFindsNoRoom) {
  PacketQueue queue(1);  // one packet at a time
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 50; ++t) times.push_back(t);
  EventFeed feed(std::make_unique<MadeSource>(times), queue, {});
  feed.start();
  EXPECT_TRUE(comes_true([&] { return !queue.is_open(); }));
  EXPECT_EQ(feed.lost_events() + all_of(queue).size(), 50U);
  EXPECT_GT(feed.lost_events(), 0U);
}

TEST(EventFeed, WaitsForRoomWhereItShall) {
  PacketQueue queue(1);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 50; ++t) times.push_back(t);
  EventFeed feed(std::make_unique<MadeSource>(times), queue, {.waits = true});
  feed.start();
  EXPECT_EQ(all_of(queue).size(), 50U);
  EXPECT_EQ(feed.lost_events(), 0U);
}

TEST(RecordedCopy, EndsWhereTheCamerasClockBeginsAnew) {
  MadeSource source({});
  RecordedCopy copy(source, false);
  CameraPacket packet;
  packet.events.resize(1);
  packet.events[0].t = camera_time(1'000);
  copy.put(packet);
  packet.events[0].t = camera_time(10);
  copy.put(packet);
  copy.put(packet);
  EXPECT_TRUE(copy.ended_early());
  CameraPacket got;
  ASSERT_EQ(copy.receive(got, std::chrono::milliseconds(1)), CameraSource::Received::packet);
  EXPECT_EQ(got.events.front().t, camera_time(1'000));
  EXPECT_EQ(copy.receive(got, std::chrono::milliseconds(1)), CameraSource::Received::ended);
}

}  // namespace
}  // namespace tactile
