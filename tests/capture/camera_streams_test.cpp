#include "tactile/capture/camera_streams.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "tactile/capture/pace.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/simulated_recording.hpp"

namespace tactile::capture {
namespace {

CameraPacket packet_at(std::initializer_list<std::int64_t> times_us) {
  CameraPacket packet;
  for (const std::int64_t t : times_us) packet.events.push_back(test::event_at(t));
  return packet;
}

std::vector<std::int64_t> times_of(const CameraPacket& packet) {
  std::vector<std::int64_t> times;
  for (const events::Event& event : packet.events) times.push_back(us_of(event.t));
  return times;
}

TEST(AscendingTimes, TakesOutWhatStepsBackWithinAPacketAndBetweenTwo) {
  AscendingTimes times;
  SourceDrops drops;
  CameraPacket packet = packet_at({10, 10, 30, 20, 30, 40});
  times.keep(packet, "a", drops);
  EXPECT_EQ(drops.events, 1U);
  EXPECT_EQ(times_of(packet), (std::vector<std::int64_t>{10, 10, 30, 30, 40}));
  packet = packet_at({35, 39, 40, 41});
  times.keep(packet, "a", drops);
  EXPECT_EQ(drops.events, 3U);
  EXPECT_EQ(times_of(packet), (std::vector<std::int64_t>{40, 41}));
  packet = packet_at({});
  times.keep(packet, "a", drops);
  EXPECT_EQ(drops.packets, 0U);
  packet = packet_at({11, 12});
  times.keep(packet, "a", drops);
  EXPECT_EQ(drops.events, 5U);
  EXPECT_EQ(drops.packets, 1U) << "the whole of it was earlier";
  EXPECT_EQ(drops.back_in_time, drops.total());
}

TEST(AscendingTimes, CountsWhatIsNoEventApart) {
  AscendingTimes times;
  SourceDrops drops;
  CameraPacket packet;
  packet.imu = {{.t = camera_time(10)}, {.t = camera_time(5)}, {.t = camera_time(11)}};
  times.keep(packet, "a", drops);
  EXPECT_EQ(packet.imu.size(), 2U);
  EXPECT_EQ(drops.events, 0U);
  EXPECT_EQ(drops.others, 1U);
  EXPECT_EQ(drops.back_in_time.others, 1U);
}

TEST(AscendingTimes, ThrowsWhereTheClockWasSetBack) {
  AscendingTimes times;
  SourceDrops drops;
  CameraPacket packet = packet_at({5'000'000});
  times.keep(packet, "tcp://camera:1", drops);
  packet = packet_at({5'000'001, 3'999'999, 4'000'000});
  try {
    times.keep(packet, "tcp://camera:1", drops);
    FAIL() << "it was taken";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("tcp://camera:1: its time went back by 1.000 s"), 0U) << error.what();
  }
  EXPECT_EQ(drops.back_in_time, (LostElements{.packets = 1, .events = 3, .others = 0})) << "the packet is lost whole";
}

TEST(CameraJson, HasWhatTheStreamsDeclare) {
  events::Stream stream = events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001");
  EXPECT_EQ(camera_json({&stream, 1}), nlohmann::json({{"source", "DVXplorer_DXM00001"}}));
  EXPECT_FALSE(events::is_simulated({&stream, 1}));
  set_info(stream, readout_mode_attribute, "constant-500");
  set_info(stream, readout_mode_attribute, "variable-5000");
  set_info(stream, events::simulated_attribute, "true");
  EXPECT_EQ(camera_json({&stream, 1}).at("readout_mode"), "variable-5000");
  EXPECT_TRUE(events::is_simulated({&stream, 1}));
}

TEST(Pace, LetsEverythingThroughAtSpeedZeroAndHoldsBackWhatIsNotDue) {
  Pace at_once(0);
  at_once.begin(camera_time(0));
  EXPECT_TRUE(at_once.wait_for(CameraTime::max(), std::chrono::milliseconds(0)));
  Pace paced(1);
  paced.begin(camera_time(0));
  EXPECT_TRUE(paced.wait_for(camera_time(0), std::chrono::milliseconds(0)));
  EXPECT_TRUE(paced.wait_for(camera_time(-5'000'000), std::chrono::milliseconds(0)));
  EXPECT_FALSE(paced.wait_for(camera_time(3'600'000'000), std::chrono::milliseconds(1))) << "an hour on";
  EXPECT_FALSE(paced.wait_for(CameraTime::max(), std::chrono::milliseconds(1)));
  const auto begun = std::chrono::steady_clock::now();
  Pace fast(10);
  fast.begin(camera_time(1'000'000));
  EXPECT_TRUE(fast.wait_for(camera_time(1'500'000), std::chrono::seconds(60)));
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(50));
}

}  // namespace
}  // namespace tactile::capture
