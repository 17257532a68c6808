#include "tactile/capture/camera_broadcast.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "events/made_recording.hpp"
#include "support/comes_true.hpp"
#include "tactile/core/error.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;

const transport::NetworkAddress any_port{
    .kind = transport::NetworkAddress::Kind::tcp, .host = "127.0.0.1", .port = 0, .path = {}};

capture::CameraPacket packet_at(std::int32_t stream_id, const std::vector<std::int64_t>& times) {
  capture::CameraPacket packet;
  packet.stream_id = stream_id;
  for (const std::int64_t t : times) packet.events.push_back(event_at(t));
  return packet;
}

std::vector<std::int64_t> next_times(transport::DvStreamClient& client) {
  EXPECT_EQ(client.receive(long_enough), transport::DvStreamClient::Received::packet);
  std::vector<std::int64_t> times;
  for (const events::Event& event : client.events()) times.push_back(us_of(event.t));
  return times;
}

TEST(CameraBroadcast, CutsWhereAPacketWouldLastTooLongHoldTooMuchOrGoBack) {
  transport::DvStreamServer server(any_port, events::event_stream_declaration({640, 480}, "A"));
  transport::DvStreamClient client(server.address(), long_enough);
  capture::CameraBroadcast broadcast({.packet_span = 100us, .packet_events = 3});
  broadcast.add(0, server);
  broadcast.send(packet_at(0, {0, 99, 100, 199, 200, 200, 200, 200, 150, 151}));
  using Times = std::vector<std::int64_t>;
  EXPECT_EQ(next_times(client), (Times{0, 99}));
  EXPECT_EQ(next_times(client), (Times{100, 199}));
  EXPECT_EQ(next_times(client), (Times{200, 200, 200}));
  EXPECT_EQ(next_times(client), (Times{200}));
  EXPECT_EQ(next_times(client), (Times{150, 151}));
  EXPECT_EQ(broadcast.counts().packets, 5U);
  EXPECT_EQ(broadcast.counts().events, 10U);
}

TEST(CameraBroadcast, HandsEachStreamToItsServersAndDropsTheRest) {
  events::Stream imu = stream_of(2, events::StreamType::imu, "IMUS");
  transport::DvStreamServer events(any_port, events::event_stream_declaration({640, 480}, "A")),
      again(any_port, events::event_stream_declaration({640, 480}, "A")), samples(any_port, imu);
  transport::DvStreamClient events_client(events.address(), long_enough), again_client(again.address(), long_enough),
      imu_client(samples.address(), long_enough);
  capture::CameraBroadcast broadcast;
  broadcast.add(0, events);
  broadcast.add(0, again);
  broadcast.add(2, samples);
  capture::CameraPacket packet;
  packet.stream_id = 2;
  packet.imu.resize(4);
  broadcast.send(packet);
  packet.stream_id = 3;
  broadcast.send(packet);
  broadcast.send(packet_at(0, {7}));
  EXPECT_EQ(next_times(events_client), std::vector<std::int64_t>{7});
  EXPECT_EQ(next_times(again_client), std::vector<std::int64_t>{7});
  ASSERT_EQ(imu_client.receive(long_enough), transport::DvStreamClient::Received::packet);
  EXPECT_EQ(imu_client.imu().size(), 4U);
  EXPECT_EQ(broadcast.counts().imu_samples, 4U);
  EXPECT_EQ(broadcast.counts().events, 1U);
}

TEST(CameraBroadcast, RefusesOptionsOutOfRange) {
  EXPECT_THROW(capture::CameraBroadcast({.packet_span = 0us}), Error);
  EXPECT_THROW(capture::CameraBroadcast({.packet_events = 0}), Error);
}

}  // namespace
}  // namespace tactile::test
