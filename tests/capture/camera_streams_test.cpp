#include "tactile/capture/camera_streams.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "tactile/capture/pace.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

CameraPacket packet_at(std::initializer_list<std::int64_t> times_us) {
  CameraPacket packet;
  for (const std::int64_t t : times_us) packet.events.push_back(test::event_at(t));
  return packet;
}

std::vector<std::int64_t> times_of(const CameraPacket& packet) {
  std::vector<std::int64_t> times;
  for (const Event& event : packet.events) times.push_back(us_of(event.t));
  return times;
}

TEST(AscendingTimes, TakesOutWhatStepsBackWithinAPacketAndBetweenTwo) {
  AscendingTimes times;
  CameraPacket packet = packet_at({10, 10, 30, 20, 30, 40});
  EXPECT_EQ(times.keep(packet, "a"), 1U);
  EXPECT_EQ(times_of(packet), (std::vector<std::int64_t>{10, 10, 30, 30, 40}));
  packet = packet_at({35, 39, 40, 41});
  EXPECT_EQ(times.keep(packet, "a"), 2U);
  EXPECT_EQ(times_of(packet), (std::vector<std::int64_t>{40, 41}));
  packet = packet_at({});
  EXPECT_EQ(times.keep(packet, "a"), 0U);
}

TEST(AscendingTimes, ThrowsWhereTheClockWasSetBack) {
  AscendingTimes times;
  CameraPacket packet = packet_at({5'000'000});
  times.keep(packet, "tcp://camera:1");
  packet = packet_at({3'999'999});
  try {
    times.keep(packet, "tcp://camera:1");
    FAIL() << "it was taken";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("tcp://camera:1: its time went back by 1.000 s"), 0U) << error.what();
  }
}

TEST(CameraJson, TellsWhatTheStreamsSay) {
  Stream stream = event_stream_declaration({640, 480}, "DVXplorer_DXM00001");
  EXPECT_EQ(camera_json({&stream, 1}), nlohmann::json({{"source", "DVXplorer_DXM00001"}}));
  EXPECT_FALSE(says_simulated({&stream, 1}));
  set_info(stream, readout_mode_attribute, "constant-500");
  set_info(stream, readout_mode_attribute, "variable-5000");
  set_info(stream, simulated_attribute, "true");
  EXPECT_EQ(camera_json({&stream, 1}).at("readout_mode"), "variable-5000");
  EXPECT_TRUE(says_simulated({&stream, 1}));
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
}  // namespace tactile
