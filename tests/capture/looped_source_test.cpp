#include "tactile/capture/looped_source.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "events/made_recording.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;
using Received = capture::CameraSource::Received;

/// Events at these times, one a packet, then a trigger, then the end.
class ShortSource final : public capture::CameraSource {
 public:
  ShortSource(std::vector<std::int64_t> events, std::int64_t trigger) : events_(std::move(events)), trigger_(trigger) {}

  std::string name() const override { return "short"; }
  std::span<const events::Stream> streams() const override { return {&stream_, 1}; }
  nlohmann::json camera() const override { return {{"source", "A"}}; }
  capture::SourceDrops drops() const override {
    capture::SourceDrops drops;
    drops.packets = 1;
    drops.events = 2;
    return drops;
  }
  capture::CameraSource::Received receive(capture::CameraPacket& packet, std::chrono::microseconds /*patience*/) override {
    packet.clear();
    if (next_ > events_.size()) return Received::ended;
    if (next_ < events_.size()) {
      packet.events.push_back(event_at(events_[next_]));
    } else {
      packet.triggers.push_back({.t = camera_time(trigger_), .type = 1});
    }
    ++next_;
    return Received::packet;
  }

 private:
  events::Stream stream_ = events::event_stream_declaration({640, 480}, "A");
  std::vector<std::int64_t> events_;
  std::int64_t trigger_;
  std::size_t next_ = 0;
};

TEST(LoopedSource, BeginsAgainAfterTheLatestOfAllStreams) {
  int opened = 0;
  const auto source = capture::looped_source(
      [&]() -> std::unique_ptr<capture::CameraSource> {
        ++opened;
        return std::make_unique<ShortSource>(std::vector<std::int64_t>{1000, 1010}, 1030);
      },
      5us);
  std::vector<std::int64_t> events, triggers;
  capture::CameraPacket packet;
  for (int i = 0; i < 9; ++i) {
    ASSERT_EQ(source->receive(packet, 0ms), Received::packet);
    for (const events::Event& event : packet.events) events.push_back(us_of(event.t));
    for (const events::Trigger& trigger : packet.triggers) triggers.push_back(us_of(trigger.t));
  }
  EXPECT_EQ(events, (std::vector<std::int64_t>{1000, 1010, 1035, 1045, 1070, 1080}));
  EXPECT_EQ(triggers, (std::vector<std::int64_t>{1030, 1065, 1100}));
  EXPECT_EQ(opened, 3);
  EXPECT_EQ(source->drops().packets, 3U);
  EXPECT_EQ(source->drops().events, 6U);
  EXPECT_EQ(source->streams().front().source, "A");
}

TEST(LoopedSource, EndsWhereARoundBringsNothing) {
  class Nothing final : public capture::CameraSource {
   public:
    std::string name() const override { return "nothing"; }
    std::span<const events::Stream> streams() const override { return {}; }
    nlohmann::json camera() const override { return nlohmann::json::object(); }
    capture::SourceDrops drops() const override { return {}; }
    capture::CameraSource::Received receive(capture::CameraPacket& /*packet*/, std::chrono::microseconds /*patience*/) override {
      return Received::ended;
    }
  };
  const auto source = capture::looped_source([] { return std::make_unique<Nothing>(); }, 1us);
  capture::CameraPacket packet;
  EXPECT_EQ(source->receive(packet, 0ms), Received::ended);
  EXPECT_EQ(source->receive(packet, 0ms), Received::ended);
}

}  // namespace
}  // namespace tactile::test
