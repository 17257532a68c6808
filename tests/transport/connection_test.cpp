#include "tactile/transport/connection.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <future>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/held_port.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "transport/scripted_server.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;

std::span<const std::byte> bytes_in(const std::string& text) { return std::as_bytes(std::span(text)); }

/// Everything that comes until the server closes.
std::string all_of(transport::Connection& connection) {
  std::string all;
  std::array<std::byte, 1000> bytes{};
  while (const auto got = connection.receive(bytes, long_enough)) all.append(reinterpret_cast<const char*>(bytes.data()), *got);
  return all;
}

TEST(Connection, CarriesBytesBothWaysAndDetectsThatTheServerCloses) {
  std::string heard;
  {
    const ScriptedServer server([&](ScriptedServer::Socket& client) {
      heard.resize(5);
      asio::read(client, asio::buffer(heard));
      send_all(client, std::string(300'000, 'a') + "end");
    });
    transport::Connection connection(server.address(), long_enough);
    EXPECT_EQ(connection.address().text(), server.address().text());
    connection.send(bytes_in("hello"), long_enough);
    EXPECT_EQ(all_of(connection), std::string(300'000, 'a') + "end");
  }
  EXPECT_EQ(heard, "hello");
}

TEST(Connection, ConnectsToAUnixSocketWithoutArrivalTimes) {
  const TemporaryFolder folder;
  const ScriptedServer server([](ScriptedServer::Socket& client) { send_all(client, "from a file"); },
                              asio::local::stream_protocol::endpoint((folder / "socket").string()));
  transport::Connection connection(server.address(), long_enough);
  EXPECT_EQ(all_of(connection), "from a file");
  EXPECT_FALSE(connection.reports_arrivals());
  EXPECT_FALSE(connection.arrived());
}

TEST(Connection, ReportsWhenBytesArrivedEvenIfTheyAreReadLate) {
  const ScriptedServer server([](ScriptedServer::Socket& client) {
    std::string asked(1, ' ');
    std::error_code error;
    while (asio::read(client, asio::buffer(asked), error) == 1) send_all(client, "come");
  });
  transport::Connection connection(server.address(), long_enough);
  EXPECT_TRUE(connection.reports_arrivals());
  std::array<std::byte, 10> bytes{};
  HostTime earliest{};
  // It may take the system a moment until it notes when bytes come.
  EXPECT_TRUE(comes_true([&] {
    connection.send(bytes_in("?"), long_enough);
    std::this_thread::sleep_for(50ms);
    if (connection.receive(bytes, long_enough) != std::optional<std::size_t>(4)) return false;
    const HostTime now = host_now();
    const std::optional<HostTime> arrived = connection.arrived();
    if (!arrived) return false;
    EXPECT_GE(*arrived, earliest);
    EXPECT_LE(*arrived, now);
    earliest = *arrived;
    return now - *arrived > 25ms;
  }));
}

TEST(Connection, ResolvesANameAndTriesEveryAddressOfIt) {
  // "localhost" is often ::1 first, where nobody listens.
  const ScriptedServer server([](ScriptedServer::Socket& client) { send_all(client, "here"); });
  transport::NetworkAddress address = server.address();
  address.host = "localhost";
  transport::Connection connection(address, long_enough);
  EXPECT_EQ(all_of(connection), "here");
}

TEST(Connection, ReceivesNothingWhileTheServerIsSilent) {
  const ScriptedServer server([](ScriptedServer::Socket& client) { until_closed(client); });
  transport::Connection connection(server.address(), long_enough);
  std::array<std::byte, 10> bytes{};
  EXPECT_EQ(connection.receive(bytes, 0ms), std::optional<std::size_t>(0));
  EXPECT_EQ(connection.receive(bytes, 20ms), std::optional<std::size_t>(0));
}

TEST(Connection, NamesTheAddressIfNoServerListens) {
  const HeldPort held;
  const transport::NetworkAddress address{
      .kind = transport::NetworkAddress::Kind::tcp, .host = "127.0.0.1", .port = held.port(), .path = {}};
  const std::string error = error_of([&] { transport::Connection(address, long_enough); });
  EXPECT_NE(error.find(address.text()), std::string::npos) << error;
  EXPECT_NE(error.find("refused"), std::string::npos) << error;
}

TEST(Connection, RejectsAnUnknownHost) {
  const std::string error =
      error_of([] { transport::Connection(transport::network_address("tcp://no-such-host.invalid:1"), 20s); });
  EXPECT_NE(error.find("no-such-host.invalid"), std::string::npos) << error;
}

std::ptrdiff_t open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

TEST(Connection, AcceptsNoFileDescriptorsFromALocalServer) {
  const TemporaryFolder folder;
  std::promise<void> sent, seen;
  const ScriptedServer server(
      [&](ScriptedServer::Socket& client) {
        alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(int))> control{};
        char byte = 'x';
        iovec part{.iov_base = &byte, .iov_len = 1};
        msghdr message{};
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = control.size();
        cmsghdr* const header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(sizeof(int));
        const int handed_over = STDERR_FILENO;
        std::memcpy(CMSG_DATA(header), &handed_over, sizeof handed_over);
        EXPECT_EQ(::sendmsg(client.native_handle(), &message, 0), 1);
        sent.set_value();
        seen.get_future().wait();
      },
      asio::local::stream_protocol::endpoint((folder / "socket").string()));
  transport::Connection connection(server.address(), long_enough);
  sent.get_future().wait();
  const std::ptrdiff_t before = open_files();
  std::array<std::byte, 8> bytes{};
  EXPECT_EQ(connection.receive(bytes, long_enough), std::size_t{1});
  EXPECT_EQ(open_files(), before);
  seen.set_value();
}

TEST(Connection, RejectsAMissingSocket) {
  const TemporaryFolder folder;
  const std::string path = (folder / "none").string();
  const std::string error = error_of([&] { transport::Connection(transport::network_address("unix:" + path), long_enough); });
  EXPECT_NE(error.find(path), std::string::npos) << error;
  EXPECT_NE(error.find("No such file"), std::string::npos) << error;
}

TEST(Connection, GivesUpOnAServerThatDoesNotAnswer) {
  // A listener that never accepts, with no place left in its queue, answers nobody on a unix socket or by TCP.
  asio::io_context context;
  asio::ip::tcp::acceptor listener(context, asio::ip::tcp::v4());
  listener.bind({asio::ip::address_v4::loopback(), 0});
  listener.listen(0);
  transport::NetworkAddress address;
  address.host = "127.0.0.1";
  address.port = listener.local_endpoint().port();
  std::vector<transport::Connection> waiting;
  const std::string error = error_of([&] {
    for (int i = 0; i < 8; ++i) waiting.emplace_back(address, 300ms);
  });
  EXPECT_NE(error.find("no answer within 0.3"), std::string::npos) << error;
}

TEST(Connection, AcceptsAnAnswerInTimeEvenIfItIsReadLate) {
  // Loopback answers within the call that asks: a patience of nothing stands for a thread that was held up for all of it.
  const ScriptedServer server([](ScriptedServer::Socket& client) { until_closed(client); });
  EXPECT_NO_THROW(transport::Connection(server.address(), 0ms));
}

TEST(Connection, ReportsThatItBroke) {
  std::promise<void> connected;
  const ScriptedServer server([&](ScriptedServer::Socket& client) {
    connected.get_future().wait();
    reset(client);
  });
  transport::Connection connection(server.address(), long_enough);
  connected.set_value();
  std::array<std::byte, 10> bytes{};
  const std::string error = error_of([&] {
    while (connection.receive(bytes, long_enough)) {
    }
  });
  EXPECT_NE(error.find(server.address().text()), std::string::npos) << error;
  EXPECT_NE(error.find("broke"), std::string::npos) << error;
}

TEST(Connection, SendingToALostServerIsAnErrorAndNoSignal) {
  std::promise<void> connected;
  const ScriptedServer server([&](ScriptedServer::Socket& client) {
    connected.get_future().wait();
    reset(client);
  });
  transport::Connection connection(server.address(), long_enough);
  connected.set_value();
  const std::string much(1 << 20, 'x');
  const std::string error = error_of([&] {
    for (int i = 0; i < 1000; ++i) connection.send(bytes_in(much), long_enough);
  });
  EXPECT_NE(error.find("broke"), std::string::npos) << error;
}

TEST(Connection, SendingToAServerThatReadsNothingEndsInTime) {
  std::promise<void> over;
  const ScriptedServer server([&](ScriptedServer::Socket&) { over.get_future().wait(); });
  transport::Connection connection(server.address(), long_enough);
  const std::string much(1 << 20, 'x');
  const std::string error = error_of([&] {
    for (int i = 0; i < 1000; ++i) connection.send(bytes_in(much), 200ms);
  });
  over.set_value();
  EXPECT_NE(error.find("accepted no bytes for 0.2"), std::string::npos) << error;
}

}  // namespace
}  // namespace tactile::test
