#include "tactile/transport/dv/dv_stream_client.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "events/counted_memory.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "transport/dv/dv_stream_bytes.hpp"
#include "transport/scripted_server.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;
using Received = transport::DvStreamClient::Received;

const std::vector<events::Event> two_events{event(10, 1, 2, 1), event(20, 3, 4, 0)};
const std::vector<events::Event> another_event{event(30, 639, 479, 1)};

/// A server that sends these bytes and closes.
ScriptedServer::Script sends(std::string bytes) {
  return [bytes = std::move(bytes)](ScriptedServer::Socket& client) { send_all(client, bytes); };
}

/// Sends these bytes, and then nothing more until the test is over.
class StallingServer {
 public:
  explicit StallingServer(std::string bytes)
      : server_([this, bytes = std::move(bytes)](ScriptedServer::Socket& client) {
          send_all(client, bytes);
          over_.get_future().wait();
        }) {}
  ~StallingServer() { over_.set_value(); }
  const transport::NetworkAddress& address() const { return server_.address(); }

 private:
  std::promise<void> over_;
  ScriptedServer server_;
};

/// Opens a client whose patience is short, of one stalling server after the other until one sends its header within it.
void with_short_patience(std::chrono::milliseconds patience, const std::string& bytes,
                         const std::function<void(transport::DvStreamClient&)>& use) {
  ASSERT_TRUE(comes_true([&] {
    const StallingServer server(bytes);
    std::optional<transport::DvStreamClient> client;
    try {
      client.emplace(server.address(), patience);
    } catch (const Error&) {  // the machine is busy
      return false;
    }
    use(*client);
    return true;
  }));
}

std::vector<events::Event> all_events(transport::DvStreamClient& client) {
  std::vector<events::Event> all;
  for (;;) {
    const Received received = client.receive(long_enough);
    if (received == Received::closed) return all;
    if (received == Received::packet) all.insert(all.end(), client.events().begin(), client.events().end());
  }
}

std::string error_on_opening(const std::string& bytes) {
  const ScriptedServer server(sends(bytes));
  const std::string error = error_of([&] { transport::DvStreamClient(server.address(), long_enough); });
  EXPECT_NE(error.find(server.address().text()), std::string::npos) << error;
  EXPECT_NE(error.find("expected"), std::string::npos) << error;
  return error;
}

TEST(DvStreamClient, ReadsHeaderAndPacketsInAnyPieces) {
  const std::string bytes = event_stream_start() + packet(0, event_payload(two_events)) + packet(0, event_payload(another_event));
  for (const std::size_t piece : {1U, 3U, 7U, 100U, 100'000U}) {
    const ScriptedServer server([&](ScriptedServer::Socket& client) {
      client.set_option(asio::ip::tcp::no_delay(true));
      for (std::size_t at = 0; at < bytes.size(); at += piece) send_all(client, bytes.substr(at, piece));
    });
    transport::DvStreamClient client(server.address(), long_enough);
    EXPECT_EQ(client.stream().type, events::StreamType::events);
    EXPECT_EQ(client.stream().source, "DVXplorer_DXM00001");
    EXPECT_EQ(client.stream().size, (events::SensorSize{640, 480}));
    EXPECT_EQ(client.compression(), events::Compression::none);
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    EXPECT_EQ(std::vector<events::Event>(client.events().begin(), client.events().end()), two_events);
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    EXPECT_EQ(std::vector<events::Event>(client.events().begin(), client.events().end()), another_event);
    EXPECT_EQ(client.receive(long_enough), Received::closed);
    EXPECT_EQ(client.receive(long_enough), Received::closed);
    EXPECT_EQ(client.bytes_received(), bytes.size());
  }
}

TEST(DvStreamClient, ReadsPacketsSmallAndLargeThatComeTogether) {
  std::string bytes = event_stream_start();
  std::vector<events::Event> sent;
  std::size_t packets = 0;
  for (const std::size_t count : {1U, 1U, 20U, 1'000U, 1'021U, 1'022U, 1'023U, 1U, 5'000U, 3U, 2'047U, 1U, 1U}) {
    std::vector<events::Event> part;
    for (std::size_t i = 0; i < count; ++i) {
      const auto k = static_cast<int>(sent.size() + i);
      part.push_back(event(k, k % 640, 7, k % 2));
    }
    bytes += packet(0, event_payload(part));
    sent.insert(sent.end(), part.begin(), part.end());
    ++packets;
  }
  const StallingServer server(bytes);
  transport::DvStreamClient client(server.address(), long_enough);
  std::vector<events::Event> got;
  while (packets > 0 && client.receive(long_enough) == Received::packet) {
    got.insert(got.end(), client.events().begin(), client.events().end());
    --packets;
  }
  EXPECT_EQ(packets, 0U);
  EXPECT_EQ(got, sent);
  EXPECT_FALSE(client.more_came()) << "of the last one";
  EXPECT_EQ(client.receive(0ms), Received::nothing) << "nothing is left, nor waited for";
  EXPECT_EQ(client.bytes_received(), bytes.size());
}

TEST(DvStreamClient, ReadsEveryKindOfFrame) {
  const std::string payload = event_payload(two_events);
  for (const std::string& sent :
       {event_stream_start(1) + packet(0, lz4(payload)), event_stream_start(2) + packet(0, lz4(payload, {.checksums = true})),
        event_stream_start(1) + packet(0, lz4(payload, {.block = LZ4F_max4MB, .mode = LZ4F_blockIndependent})),
        event_stream_start(3) + packet(0, zstd(payload)), event_stream_start(4) + packet(0, zstd_without_size(payload))}) {
    const ScriptedServer server(sends(sent));
    transport::DvStreamClient client(server.address(), long_enough);
    EXPECT_EQ(all_events(client), two_events);
    EXPECT_EQ(client.problems().broken_packets, 0U);
  }
}

TEST(DvStreamClient, ReadsFromAUnixSocket) {
  const TemporaryFolder folder;
  const ScriptedServer server(sends(event_stream_start() + packet(0, event_payload(two_events))),
                              asio::local::stream_protocol::endpoint((folder / "socket").string()));
  transport::DvStreamClient client(server.address(), long_enough);
  EXPECT_EQ(all_events(client), two_events);
}

TEST(DvStreamClient, SendsNothing) {
  std::string heard = "unset";
  {
    const ScriptedServer server([&](ScriptedServer::Socket& client) {
      send_all(client, event_stream_start() + packet(0, event_payload(two_events)));
      heard = until_closed(client);
    });
    transport::DvStreamClient client(server.address(), long_enough);
    EXPECT_EQ(client.receive(long_enough), Received::packet);
  }
  EXPECT_EQ(heard, "");
}

TEST(DvStreamClient, AcceptsSilence) {
  with_short_patience(50ms, event_stream_start() + packet(0, event_payload(two_events)), [](transport::DvStreamClient& client) {
    EXPECT_EQ(client.receive(long_enough), Received::packet);
    EXPECT_EQ(client.receive(0ms), Received::nothing);
    EXPECT_EQ(client.receive(200ms), Received::nothing) << "longer than the patience it was opened with";
    EXPECT_TRUE(client.events().empty());
  });
}

TEST(DvStreamClient, RejectsAnOldServerWithAnExplanation) {
  const std::string error = error_on_opening(packet(0, event_payload(two_events)));
  EXPECT_NE(error.find("before 1.6"), std::string::npos) << error;
}

TEST(DvStreamClient, RejectsGarbage) {
  EXPECT_NE(error_on_opening("HTTP/1.1 400 Bad Request\r\n\r\n").find("'HTTP/1.1 400'"), std::string::npos);
  error_on_opening(std::string(100'000, '\xff'));
  std::string random;
  std::uint32_t state = 1;
  for (int i = 0; i < 100'000; ++i) random += static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
  error_on_opening(random);
}

TEST(DvStreamClient, RejectsAHeaderThatIsTooLargeOrBroken) {
  std::string large = event_stream_start();
  put(large, 0, std::uint32_t{1 << 30});
  largest_memory_request = 0;
  EXPECT_NE(error_on_opening(large).find("1073741824"), std::string::npos);
  EXPECT_LT(largest_memory_request.load(), std::size_t{1} << 20);
  std::string broken = event_stream_start();
  put(broken, 4, std::uint32_t{0x7fffffff});
  EXPECT_NE(error_on_opening(broken).find("does not decode"), std::string::npos);
  EXPECT_NE(error_on_opening(event_stream_start(9)).find("compression 9"), std::string::npos);
}

TEST(DvStreamClient, AcceptsExactlyOneStreamOfAKnownType) {
  const std::string none = stream_start(0, "");
  EXPECT_NE(error_on_opening(none).find("no stream"), std::string::npos);
  const std::string two = stream_start(0, event_node(0, 640, 480, "A") + plain_node(1, "IMUS"));
  EXPECT_NE(error_on_opening(two).find("2 streams"), std::string::npos);
  EXPECT_NE(error_on_opening(stream_start(0, plain_node(0, "BBOX"))).find("'BBOX'"), std::string::npos);
}

TEST(DvStreamClient, WaitsForAHeaderNoLongerThanItsPatience) {
  for (const std::string& begun : {std::string(), event_stream_start().substr(0, 40)}) {
    const StallingServer server(begun);
    const std::string error = error_of([&] { transport::DvStreamClient(server.address(), 100ms); });
    EXPECT_NE(error.find("no complete header within 0.1"), std::string::npos) << error;
  }
}

TEST(DvStreamClient, ReportsAServerThatClosesBeforeItsHeader) {
  EXPECT_NE(error_on_opening("").find("before its header"), std::string::npos);
  EXPECT_NE(error_on_opening(event_stream_start().substr(0, 100)).find("before its header"), std::string::npos);
}

TEST(DvStreamClient, KeepsPacketsBeforeAStreamThatEndsInsideAPacket) {
  const std::string whole = event_stream_start() + packet(0, event_payload(two_events));
  const std::string next = packet(0, event_payload(another_event));
  for (const std::size_t cut : {std::size_t{1}, std::size_t{8}, std::size_t{9}, next.size() - 1}) {
    const ScriptedServer server(sends(whole + next.substr(0, cut)));
    transport::DvStreamClient client(server.address(), long_enough);
    ASSERT_EQ(client.receive(long_enough), Received::packet) << cut;
    EXPECT_EQ(client.events().size(), 2U);
    const std::string error = error_of([&] {
      while (client.receive(long_enough) != Received::closed) {
      }
    });
    EXPECT_NE(error.find("ended inside a packet"), std::string::npos) << error;
  }
}

TEST(DvStreamClient, LimitsTheWaitForTheRestOfAPacket) {
  const std::string begun = event_stream_start() + packet(0, event_payload(two_events)).substr(0, 30);
  with_short_patience(200ms, begun, [](transport::DvStreamClient& client) {
    const std::string error = error_of([&] {
      for (;;) client.receive(10ms);
    });
    EXPECT_NE(error.find("stopped inside a packet"), std::string::npos) << error;
  });
}

TEST(DvStreamClient, ReportsAServerThatDies) {
  std::promise<void> opened;
  const ScriptedServer server([&](ScriptedServer::Socket& socket) {
    send_all(socket, event_stream_start());
    opened.get_future().wait();
    reset(socket);
  });
  transport::DvStreamClient client(server.address(), long_enough);
  opened.set_value();
  const std::string error = error_of([&] {
    while (client.receive(long_enough) != Received::closed) {
    }
  });
  EXPECT_NE(error.find("broke"), std::string::npos) << error;
}

TEST(DvStreamClient, EndsAtAPacketOfImpossibleSize) {
  for (const std::uint32_t size : {transport::dv_packet_limit + 1, 0x80000000U, 0xffffffffU}) {
    std::string impossible = packet(0, event_payload(two_events));
    put(impossible, 4, size);
    const ScriptedServer server(sends(event_stream_start() + packet(0, event_payload(two_events)) + impossible));
    transport::DvStreamClient client(server.address(), long_enough);
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    const std::string error = error_of([&] { client.receive(long_enough); });
    EXPECT_NE(error.find(std::to_string(size)), std::string::npos) << error;
  }
}

TEST(DvStreamClient, CountsProblemsAndContinues) {
  std::string claims_too_much = event_payload(two_events);
  put(claims_too_much, 28, std::uint32_t{1'000'000});
  const std::vector<events::Event> outside{event(40, 640, 0, 1), event(41, 0, 480, 1), event(42, -1, 0, 1), event(43, 5, 5, 2),
                                           event(44, 5, 6, 1)};
  std::string other_type = event_payload(two_events);
  other_type.replace(8, 4, "IMUS");
  const ScriptedServer server(sends(event_stream_start() + packet(0, claims_too_much) + packet(0, "short") + packet(0, "") +
                                    packet(7, event_payload(two_events)) + packet(0, other_type) +
                                    packet(0, event_payload(outside)) + packet(0, event_payload(another_event))));
  transport::DvStreamClient client(server.address(), long_enough);
  EXPECT_EQ(all_events(client), (std::vector<events::Event>{outside.back(), another_event.front()}));
  EXPECT_EQ(client.problems().broken_packets, 3U);
  EXPECT_EQ(client.problems().foreign_packets, 1U);
  EXPECT_EQ(client.problems().mismatched_packets, 1U);
  EXPECT_EQ(client.problems().out_of_range_events, 4U);
}

TEST(DvStreamClient, CountsPacketsThatCannotBeDecompressedAndContinues) {
  for (const int compression : {1, 3}) {
    const std::string sound = compression == 1 ? lz4(event_payload(two_events)) : zstd(event_payload(two_events));
    std::string damaged = sound;
    damaged[0] ^= 0x40;
    const ScriptedServer server(sends(event_stream_start(compression) + packet(0, damaged) + packet(0, sound.substr(0, 20)) +
                                      packet(0, sound + "more") + packet(0, sound)));
    transport::DvStreamClient client(server.address(), long_enough);
    EXPECT_EQ(all_events(client), two_events);
    EXPECT_EQ(client.problems().broken_packets, 3U);
  }
}

/// Waits that end although broken packets come all the while; the server may need more than one wait for its first.
void expect_waits_that_end(transport::DvStreamClient& client, std::chrono::milliseconds wait, int waits) {
  EXPECT_TRUE(comes_true([&] {
    const std::uint64_t before = client.problems().broken_packets;
    EXPECT_EQ(client.receive(wait), Received::nothing);
    if (client.problems().broken_packets > before) --waits;
    return waits == 0;
  }));
}

TEST(DvStreamClient, EndsItsWaitAlthoughBrokenPacketsNeverEnd) {
  const ScriptedServer server([](ScriptedServer::Socket& client) {
    std::error_code error;
    asio::write(client, asio::buffer(event_stream_start()), error);
    const std::string broken = packet(0, "no packet at all");
    while (!error) asio::write(client, asio::buffer(broken), error);
  });
  transport::DvStreamClient client(server.address(), long_enough);
  expect_waits_that_end(client, 50ms, 1);
}

TEST(DvStreamClient, EndsItsWaitAlthoughEmptyPacketsComeFasterThanTheyAreRead) {
  std::atomic<bool> is_over{false};
  const ScriptedServer server([&](ScriptedServer::Socket& client) {
    std::error_code error;
    asio::write(client, asio::buffer(event_stream_start()), error);
    const std::string zeros(std::size_t{4} << 20, '\0');  // each eight of them a packet of nothing
    while (!error && !is_over) asio::write(client, asio::buffer(zeros), error);
  });
  {
    transport::DvStreamClient client(server.address(), long_enough);
    expect_waits_that_end(client, 2ms, 20);
    is_over = true;
  }
}

TEST(DvStreamClient, AllocatesMemoryForReceivedBytesOnly) {
  std::string bytes = event_stream_start() + packet(0, event_payload(two_events));
  put(bytes, event_stream_start().size() + 4, transport::dv_packet_limit);
  largest_memory_request = 0;
  const ScriptedServer server(sends(bytes));
  transport::DvStreamClient client(server.address(), long_enough);
  error_of([&] { client.receive(long_enough); });
  EXPECT_LT(largest_memory_request.load(), std::size_t{2} << 20);
}

TEST(DvStreamClient, AllocatesNothingAfterTheLargestPacket) {
  std::vector<events::Event> many;
  for (int i = 0; i < 100'000; ++i) many.push_back(event(i, i % 640, i % 480, i % 2));
  for (const int compression : {0, 1, 3}) {
    const std::string payload = event_payload(many);
    const std::string sent = packet(0, compression == 0 ? payload : compression == 1 ? lz4(payload) : zstd(payload));
    std::promise<void> ready;
    const ScriptedServer server([&](ScriptedServer::Socket& client) {
      send_all(client, event_stream_start(compression) + sent);
      ready.get_future().wait();
      for (int i = 0; i < 20; ++i) send_all(client, sent);
    });
    transport::DvStreamClient client(server.address(), long_enough);
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    const std::size_t before = memory_requests;
    ready.set_value();
    for (int i = 0; i < 20; ++i) {
      ASSERT_EQ(client.receive(long_enough), Received::packet);
      EXPECT_EQ(client.events().size(), many.size());
    }
    EXPECT_LT(memory_requests - before, 20U) << compression;  // the server's own, in the same program, among them
  }
}

}  // namespace
}  // namespace tactile::test
