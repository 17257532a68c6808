// Public bags of real cameras, which are not part of this project.
#include <gtest/gtest.h>

#include <string>

#include "support/real_recordings.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/bags/ros_events.hpp"

namespace tactile::bags {
namespace {

namespace fs = std::filesystem;

fs::path real_bag(const std::string& name) { return test::real_recording("ros-event-camera/" + name); }

/// Sums over a bag's events, as the tests of event_camera_codecs publish them: times in ns, modulo 2^64.
struct Sums {
  std::uint64_t t = 0, x = 0, y = 0, on = 0, trigger_t = 0, rising = 0, channel = 0, events = 0;
  friend bool operator==(const Sums&, const Sums&) = default;
};

/// @param below_us  the part of every time below a microsecond [ns], which our times do not have
Sums sums_of(const fs::path& bag, std::uint64_t below_us = 0) {
  const auto reader = open_bag(bag);
  EventPacketDecoder decoder;
  RosEvents decoded;
  Sums sums;
  while (const auto message = reader->next()) {
    EXPECT_EQ(decoder.decode(message->serialised(), decoded), PacketDecoding::whole);
    for (const events::Event& event : decoded.events) {
      sums.t += static_cast<std::uint64_t>(us_of(event.t)) * 1'000 + below_us;
      sums.x += static_cast<std::uint64_t>(event.x);
      sums.y += static_cast<std::uint64_t>(event.y);
      sums.on += event.on;
      ++sums.events;
    }
    for (const events::Evt3Trigger& trigger : decoded.triggers) {
      sums.trigger_t += static_cast<std::uint64_t>(us_of(trigger.t)) * 1'000;
      sums.rising += trigger.is_rising ? 1 : 0;
      sums.channel += trigger.channel;
    }
  }
  EXPECT_EQ(reader->problems().truncated_bytes + reader->problems().broken_chunks + reader->problems().broken_records, 0U);
  return sums;
}

const std::string not_tested = test::not_tested_without("ros-event-camera");

TEST(RealBag, GivesThePublishedSumsOfEvt3WithTriggers) {
  const fs::path bag = real_bag("codecs/test_data_evt3_trigger");
  if (bag.empty()) GTEST_SKIP() << not_tested;
  Sums sums = sums_of(bag);
  sums.events = 0;
  EXPECT_EQ(sums,
            (Sums{.t = 1222326831810000, .x = 42078718, .y = 31656267, .on = 41439, .trigger_t = 29096982000, .rising = 1}));
}

TEST(RealBag, GivesThePublishedSumsOfAClockThatRollsOver) {
  const fs::path bag = real_bag("codecs/test_data_libcaer_rollover");
  if (bag.empty()) GTEST_SKIP() << not_tested;
  EXPECT_EQ(sums_of(bag, 18), (Sums{.t = 15762826572202229126U, .x = 111651612, .y = 82801007, .on = 181908, .events = 334331}));
}

TEST(RealBag, GivesThePublishedSumsOfMono) {
  const fs::path bag = real_bag("codecs/test_data_mono_cd");
  if (bag.empty()) GTEST_SKIP() << not_tested;
  const Sums sums = sums_of(bag);
  EXPECT_EQ(sums.events, 100U);
  EXPECT_EQ(sums.x, 34450U);
  EXPECT_EQ(sums.y, 26450U);
  EXPECT_EQ(sums.on, 50U);
}

TEST(RealBag, HasTheSameEventsInRos1AndRos2) {
  const fs::path ros1 = real_bag("py/test_events_1.bag"), ros2 = real_bag("py/test_events_1");
  if (ros1.empty() || ros2.empty()) GTEST_SKIP() << not_tested;
  const Sums sums = sums_of(ros2);
  EXPECT_GT(sums.events, 0U);
  EXPECT_EQ(sums, sums_of(ros1));
}

}  // namespace
}  // namespace tactile::bags
