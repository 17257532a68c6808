#include "tactile/transport/dv/dv_stream_server.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "events/aedat4_bytes.hpp"
#include "events/made_recording.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/transport/connection.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;
using Received = transport::DvStreamClient::Received;

const transport::NetworkAddress any_port{
    .kind = transport::NetworkAddress::Kind::tcp, .host = "127.0.0.1", .port = 0, .path = {}};
const events::Stream event_declaration = events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001");

/// What the server logged, from whatever thread.
class Log {
 public:
  std::function<void(const std::string&)> sink() {
    return [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      lines_.push_back(text);
    };
  }
  std::size_t lines_with(const std::string& part) {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::count_if(lines_.begin(), lines_.end(),
                                                  [&](const std::string& line) { return line.find(part) != std::string::npos; }));
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

std::vector<events::Event> next_events(transport::DvStreamClient& client) {
  EXPECT_EQ(client.receive(long_enough), Received::packet);
  return {client.events().begin(), client.events().end()};
}

TEST(DvStreamServer, ServesSeveralClientsTheSame) {
  transport::DvStreamServer server(any_port, event_declaration);
  EXPECT_GT(server.address().port, 0);
  std::vector<transport::DvStreamClient> clients;
  for (int i = 0; i < 3; ++i) clients.emplace_back(server.address(), long_enough);
  ASSERT_TRUE(comes_true([&] { return server.clients() == 3; })) << "three clients";
  const std::vector<events::Event> first = steady_events(1000, 0, 10, {640, 480});
  const std::vector<events::Event> second = steady_events(10, 20'000, 10, {640, 480});
  server.send(first);
  server.send(std::span<const events::Event>());  // nothing is sent of it
  server.send(second);
  for (transport::DvStreamClient& client : clients) {
    EXPECT_EQ(client.stream().source, "DVXplorer_DXM00001");
    EXPECT_EQ(client.stream().name, "events");
    EXPECT_EQ(client.stream().size, (events::SensorSize{640, 480}));
    EXPECT_EQ(next_events(client), first);
    EXPECT_EQ(next_events(client), second);
  }
  EXPECT_EQ(server.joined_clients(), 3U);
  EXPECT_EQ(server.dropped_clients(), 0U);
}

TEST(DvStreamServer, CarriesEveryTypeUnderEveryCompression) {
  const std::vector<events::Event> events = steady_events(500, 1'600'000'000'000'000, 10, {640, 480});
  const std::vector<events::ImuSample> imu{{.t = camera_time(5),
                                            .temperature_c = 30.5F,
                                            .acceleration_g = {1, 2, 3},
                                            .angular_rate_dps = {4, 5, 6},
                                            .magnetic_field_ut = {7, 8, 9}},
                                           {.t = camera_time(6)}};
  const std::vector<events::Trigger> triggers{{.t = camera_time(7), .type = 1}, {.t = camera_time(8), .type = 2}};
  events::Frame frame;
  frame.t = camera_time(100);
  frame.frame_end = camera_time(101);
  frame.width = 4;
  frame.height = 3;
  frame.pixels = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  events::Stream imu_stream = stream_of(3, events::StreamType::imu, "IMUS");
  events::Stream trigger_stream = stream_of(4, events::StreamType::triggers, "TRIG");
  events::Stream frame_stream = stream_of(5, events::StreamType::frames, "FRME");
  frame_stream.size = events::SensorSize{4, 3};
  imu_stream.info.insert(imu_stream.info.begin(), {"simulated", "true"});
  for (const events::Compression compression :
       {events::Compression::none, events::Compression::lz4, events::Compression::lz4_high, events::Compression::zstd,
        events::Compression::zstd_high}) {
    const transport::DvStreamServerOptions options{.compression = compression, .log = {}};
    transport::DvStreamServer event_server(any_port, event_declaration, options), imu_server(any_port, imu_stream, options),
        trigger_server(any_port, trigger_stream, options), frame_server(any_port, frame_stream, options);
    transport::DvStreamClient event_client(event_server.address(), long_enough), imu_client(imu_server.address(), long_enough),
        trigger_client(trigger_server.address(), long_enough), frame_client(frame_server.address(), long_enough);
    EXPECT_EQ(event_client.compression(), compression);
    event_server.send(events);
    imu_server.send(imu);
    trigger_server.send(triggers);
    frame_server.send(frame);
    EXPECT_EQ(next_events(event_client), events);
    EXPECT_TRUE(event_client.imu().empty());

    ASSERT_EQ(imu_client.receive(long_enough), Received::packet);
    EXPECT_EQ(imu_client.stream().id, 3);
    EXPECT_EQ(imu_client.stream().info, imu_stream.info);
    ASSERT_EQ(imu_client.imu().size(), 2U);
    EXPECT_EQ(imu_client.imu()[0].t, imu[0].t);
    EXPECT_EQ(imu_client.imu()[0].temperature_c, 30.5F);
    EXPECT_EQ(imu_client.imu()[0].acceleration_g[2], 3);
    EXPECT_EQ(imu_client.imu()[0].angular_rate_dps[1], 5);
    EXPECT_EQ(imu_client.imu()[0].magnetic_field_ut[0], 7);
    EXPECT_TRUE(imu_client.events().empty());

    ASSERT_EQ(trigger_client.receive(long_enough), Received::packet);
    ASSERT_EQ(trigger_client.triggers().size(), 2U);
    EXPECT_EQ(trigger_client.triggers()[1].t, triggers[1].t);
    EXPECT_EQ(trigger_client.triggers()[1].type, 2);

    ASSERT_EQ(frame_client.receive(long_enough), Received::packet);
    ASSERT_TRUE(frame_client.frame());
    EXPECT_EQ(frame_client.frame()->t, frame.t);
    EXPECT_EQ(frame_client.frame()->frame_end, frame.frame_end);
    EXPECT_EQ(frame_client.frame()->width, 4);
    EXPECT_EQ(frame_client.frame()->pixels, frame.pixels);
  }
}

TEST(DvStreamServer, LetsAClientJoinAtTheNextPacket) {
  transport::DvStreamServer server(any_port, event_declaration);
  transport::DvStreamClient early(server.address(), long_enough);
  server.send(steady_events(10, 0, 1, {640, 480}));
  EXPECT_EQ(next_events(early).size(), 10U);
  transport::DvStreamClient late(server.address(), long_enough);
  server.send(steady_events(20, 100, 1, {640, 480}));
  EXPECT_EQ(next_events(late).size(), 20U);
  EXPECT_EQ(next_events(early).size(), 20U);
}

TEST(DvStreamServer, DropsAStalledClientAndServesTheOthersCompletely) {
  Log log;
  transport::DvStreamServer server(any_port, event_declaration, {.client_queue = 1 << 20, .log = log.sink()});
  transport::Connection stalled(server.address(), long_enough);  // reads nothing, ever
  transport::DvStreamClient good(server.address(), long_enough);
  ASSERT_TRUE(comes_true([&] { return server.clients() == 2; })) << "two clients";
  const std::vector<events::Event> events = steady_events(8192, 0, 1, {640, 480});
  // The good client takes each packet before the next one is sent: only the stalled one can fall behind.
  std::size_t sent = 0;
  for (; server.dropped_clients() == 0 && sent < 4000; ++sent) {
    server.send(events);
    ASSERT_EQ(next_events(good).size(), events.size());
  }
  EXPECT_EQ(server.dropped_clients(), 1U);
  server.send(events);
  EXPECT_EQ(next_events(good), events);
  EXPECT_EQ(server.clients(), 1U);
  ASSERT_TRUE(comes_true([&] { return log.lines_with("dropped: ") == 1; })) << "the message";
  EXPECT_EQ(log.lines_with(" MB unsent"), 1U);
  EXPECT_EQ(log.lines_with("joined"), 2U);
}

TEST(DvStreamServer, KeepsItsMemoryWithinTheQueueOfAStalledClient) {
  transport::DvStreamServer server(any_port, event_declaration, {.client_queue = 4 << 20, .log = {}});
  transport::Connection stalled(server.address(), long_enough);
  ASSERT_TRUE(comes_true([&] { return server.clients() == 1; })) << "the client";
  const auto in_use = [] {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  const std::size_t before = in_use();
  std::size_t most = before;
  const std::vector<events::Event> events = steady_events(8192, 0, 1, {640, 480});
  for (int i = 0; i < 1000; ++i) {
    server.send(events);
    most = std::max(most, in_use());
  }
  EXPECT_LT(most - before, std::size_t{6} << 20);
  EXPECT_EQ(server.dropped_clients(), 1U);
}

TEST(DvStreamServer, WaitsForRoomSoThatASlowClientLosesNothing) {
  std::atomic<std::uint64_t> received{0};
  std::thread reader;
  const std::vector<events::Event> events = steady_events(8192, 0, 1, {640, 480});
  {
    transport::DvStreamServer server(any_port, event_declaration, {.client_queue = 1 << 20, .log = {}});
    transport::DvStreamClient client(server.address(), long_enough);
    ASSERT_TRUE(comes_true([&] { return server.clients() == 1; })) << "the client";
    reader = std::thread([&received, client = std::move(client)]() mutable {
      while (client.receive(long_enough) == Received::packet) {
        received += client.events().size();
        std::this_thread::sleep_for(100us);
      }
    });
    for (int i = 0; i < 500; ++i) {
      server.send(events);
      EXPECT_TRUE(server.wait_for_room(long_enough));
    }
    server.drain(long_enough);
    EXPECT_EQ(server.dropped_clients(), 0U);
  }
  reader.join();
  EXPECT_EQ(received.load(), 500 * events.size());
}

TEST(DvStreamServer, WaitsForRoomNoLongerThanItsPatienceWithAStalledClient) {
  Log log;
  transport::DvStreamServer server(any_port, event_declaration, {.client_queue = 1 << 20, .log = log.sink()});
  transport::Connection stalled(server.address(), long_enough);
  ASSERT_TRUE(comes_true([&] { return server.clients() == 1; })) << "the client";
  const std::vector<events::Event> events = steady_events(8192, 0, 1, {640, 480});
  for (int i = 0; i < 4000 && server.dropped_clients() == 0; ++i) {
    server.send(events);
    server.wait_for_room(200ms);
  }
  EXPECT_EQ(server.dropped_clients(), 1U);
  ASSERT_TRUE(comes_true([&] { return log.lines_with("dropped: it accepted no bytes for 0.2") == 1; })) << "the message";
}

TEST(DvStreamServer, EndsTheWaitForRoomOnRequest) {
  transport::DvStreamServer server(any_port, event_declaration, {.client_queue = 1 << 20, .log = {}});
  transport::Connection stalled(server.address(), long_enough);
  ASSERT_TRUE(comes_true([&] { return server.clients() == 1; })) << "the client";
  const std::vector<events::Event> events = steady_events(8192, 0, 1, {640, 480});
  bool refused_to_wait = false;
  for (int i = 0; i < 4000 && !refused_to_wait; ++i) {
    server.send(events);
    refused_to_wait = !server.wait_for_room(3600s, [] { return true; });
  }
  EXPECT_TRUE(refused_to_wait);
  EXPECT_EQ(server.dropped_clients(), 0U);
}

TEST(DvStreamServer, DetectsAClientThatCloses) {
  Log log;
  transport::DvStreamServer server(any_port, event_declaration, {.log = log.sink()});
  {
    transport::DvStreamClient client(server.address(), long_enough);
    ASSERT_TRUE(comes_true([&] { return server.clients() == 1; })) << "the client";
  }
  ASSERT_TRUE(comes_true([&] { return server.clients() == 0; })) << "its leaving";
  ASSERT_TRUE(comes_true([&] { return log.lines_with(" left") == 1; })) << "the message";
  EXPECT_EQ(server.dropped_clients(), 0U);
  EXPECT_EQ(server.joined_clients(), 1U);
  server.send(steady_events(10, 0, 1, {640, 480}));
}

TEST(DvStreamServer, DropsAClientThatSendsData) {
  Log log;
  transport::DvStreamServer server(any_port, event_declaration, {.log = log.sink()});
  transport::Connection talker(server.address(), long_enough);
  talker.send(std::as_bytes(std::span("GET /", 5)), long_enough);
  ASSERT_TRUE(comes_true([&] { return log.lines_with("dropped: it sent data") == 1; })) << "the message";
  EXPECT_EQ(server.dropped_clients(), 1U);
  EXPECT_EQ(server.clients(), 0U);
}

TEST(DvStreamServer, RejectsClientsAboveTheLimit) {
  Log log;
  transport::DvStreamServer server(any_port, event_declaration, {.clients = 2, .log = log.sink()});
  transport::DvStreamClient first(server.address(), long_enough), second(server.address(), long_enough);
  const std::string error = error_of([&] { transport::DvStreamClient(server.address(), long_enough); });
  EXPECT_NE(error.find("before its header"), std::string::npos) << error;
  EXPECT_EQ(log.lines_with("rejected"), 1U);
  EXPECT_EQ(server.clients(), 2U);
}

TEST(DvStreamServer, ServesAUnixSocketAndRemovesItsFile) {
  const TemporaryFolder folder;
  const transport::NetworkAddress address = transport::network_address("unix:" + (folder / "socket").string());
  {
    transport::DvStreamServer server(address, event_declaration);
    EXPECT_EQ(server.address().text(), address.text());
    transport::DvStreamClient client(address, long_enough);
    server.send(steady_events(10, 0, 1, {640, 480}));
    EXPECT_EQ(next_events(client).size(), 10U);
    const std::string error = error_of([&] { transport::DvStreamServer(address, event_declaration); });
    EXPECT_NE(error.find("exists already"), std::string::npos) << error;
    EXPECT_TRUE(std::filesystem::exists(address.path));
  }
  EXPECT_FALSE(std::filesystem::exists(address.path));
}

TEST(DvStreamServer, KeepsAFileInThePlaceOfItsSocket) {
  const TemporaryFolder folder;
  const std::filesystem::path path = write_bytes(folder / "precious", "data");
  error_of([&] { transport::DvStreamServer(transport::network_address("unix:" + path.string()), event_declaration); });
  EXPECT_EQ(bytes_of(path), "data");
}

TEST(DvStreamServer, RejectsAUsedPortAndAForeignHost) {
  transport::DvStreamServer server(any_port, event_declaration);
  const std::string taken = error_of([&] { transport::DvStreamServer(server.address(), event_declaration); });
  EXPECT_NE(taken.find(server.address().text()), std::string::npos) << taken;
  EXPECT_NE(taken.find("in use"), std::string::npos) << taken;
  transport::NetworkAddress elsewhere = any_port;
  elsewhere.host = "192.0.2.1";
  EXPECT_NE(
      error_of([&] { transport::DvStreamServer(elsewhere, event_declaration); }).find("expected an address of this machine"),
      std::string::npos);
  const transport::NetworkAddress nowhere = transport::network_address("unix:/no-such-folder/socket");
  EXPECT_NE(error_of([&] { transport::DvStreamServer(nowhere, event_declaration); }).find("expected a path in a folder"),
            std::string::npos);
}

TEST(DvStreamServer, RejectsAStreamThatReadersReject) {
  for (const auto& spoil : std::vector<std::function<void(events::Stream&)>>{
           [](events::Stream& s) { s.source.clear(); }, [](events::Stream& s) { s.name.clear(); },
           [](events::Stream& s) { s.size.reset(); }, [](events::Stream& s) { s.type = events::StreamType::other; },
           [](events::Stream& s) { s.id = -1; }}) {
    events::Stream stream = event_declaration;
    spoil(stream);
    EXPECT_NE(error_of([&] { transport::DvStreamServer(any_port, stream); }).find("expected"), std::string::npos);
  }
}

TEST(DvStreamServer, RejectsElementsOfAnotherType) {
  transport::DvStreamServer server(any_port, event_declaration);
  EXPECT_THROW(server.send(std::vector<events::ImuSample>(1)), Error);
  EXPECT_THROW(server.send(std::vector<events::Trigger>(1)), Error);
  EXPECT_THROW(server.send(events::Frame{}), Error);
  EXPECT_THROW(server.send(std::vector<events::Event>(transport::dv_packet_limit / sizeof(events::Event))), Error);
}

}  // namespace
}  // namespace tactile::test
