#include "tactile/capture/network_source.hpp"

#include <gtest/gtest.h>

#include <array>

#include "capture/received.hpp"
#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/comes_true.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/capture/camera_streams.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"

namespace tactile::capture {
namespace {

using std::chrono::milliseconds;

transport::NetworkAddress any_port() {
  transport::NetworkAddress address;
  address.host = "127.0.0.1";
  return address;
}

CameraPacket next_packet(CameraSource& source) {
  CameraPacket packet;
  for (int i = 0; i < 600; ++i) {
    const auto received = source.receive(packet, milliseconds(100));
    if (received == CameraSource::Received::packet) return packet;
    if (received == CameraSource::Received::ended) break;
  }
  ADD_FAILURE() << "no packet came";
  return {};
}

class OverTheNetwork : public testing::TestWithParam<events::Compression> {};

TEST_P(OverTheNetwork, BringsEventsAndWhatTheStreamKnowsOfItsCamera) {
  events::Stream stream = events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001");
  set_info(stream, readout_mode_attribute, "constant-500");
  set_info(stream, events::simulated_attribute, "true");
  transport::DvStreamServerOptions options;
  options.compression = GetParam();
  transport::DvStreamServer server(any_port(), stream, options);
  const auto source = open_network_source(server.address().text());
  ASSERT_TRUE(test::comes_true([&] { return server.clients() == 1; }));
  EXPECT_EQ(source->name(), server.address().text());
  EXPECT_TRUE(source->live());
  EXPECT_TRUE(source->simulated());
  ASSERT_EQ(source->streams().size(), 1U);
  EXPECT_EQ(source->streams()[0].size, (events::SensorSize{640, 480}));
  EXPECT_EQ(source->camera().at("source"), "DVXplorer_DXM00001");
  EXPECT_EQ(source->camera().at("readout_mode"), "constant-500");

  CameraPacket packet;
  EXPECT_EQ(source->receive(packet, milliseconds(1)), CameraSource::Received::nothing) << "silence is legal";
  for (std::int64_t i = 0; i < 3; ++i) {
    const std::vector<events::Event> events = test::steady_events(1000, 1'000'000 * i, 1, {640, 480});
    server.send(events);
    const CameraPacket got = next_packet(*source);
    EXPECT_EQ(got.stream_id, stream.id);
    EXPECT_EQ(got.events, events);
    EXPECT_TRUE(got.imu.empty() && got.triggers.empty() && !got.frame);
  }
  EXPECT_EQ(source->drops().events + source->drops().packets, 0U);
}

INSTANTIATE_TEST_SUITE_P(Compressions, OverTheNetwork,
                         testing::Values(events::Compression::none, events::Compression::lz4, events::Compression::zstd));

TEST(NetworkSource, BringsImuSamplesThroughASocketOfTheFileSystemAndEndsWithItsServer) {
  const test::TemporaryFolder folder;
  transport::NetworkAddress address;
  address.kind = transport::NetworkAddress::Kind::unix_socket;
  address.path = folder / "imu";
  auto server = std::make_unique<transport::DvStreamServer>(address, test::stream_of(0, events::StreamType::imu, "IMUS"));
  const auto source = open_network_source(address.text());
  ASSERT_TRUE(test::comes_true([&] { return server->clients() == 1; }));
  EXPECT_FALSE(source->simulated());
  EXPECT_FALSE(source->camera().contains("readout_mode"));
  std::vector<events::ImuSample> samples(3);
  for (std::size_t i = 0; i < 3; ++i)
    samples[i].t = camera_time(static_cast<std::int64_t>(i)), samples[i].angular_rate_dps[1] = 4.5F;
  server->send(samples);
  EXPECT_TRUE(test::same(next_packet(*source).imu, samples));
  server.reset();
  test::receive_all(*source);
}

TEST(NetworkSource, LeavesOutAndCountsEventsThatStepBack) {
  transport::DvStreamServer server(any_port(), events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001"));
  const auto source = open_network_source(server.address().text());
  ASSERT_TRUE(test::comes_true([&] { return server.clients() == 1; }));
  server.send(std::array{test::event_at(1'000), test::event_at(2'000)});
  server.send(std::array{test::event_at(1'999), test::event_at(2'000), test::event_at(2'001)});
  EXPECT_EQ(next_packet(*source).events.size(), 2U);
  EXPECT_EQ(next_packet(*source).events.size(), 2U);
  EXPECT_EQ(source->drops().events, 1U);
  EXPECT_EQ(source->drops().back_in_time.events, 1U);
}

}  // namespace
}  // namespace tactile::capture
