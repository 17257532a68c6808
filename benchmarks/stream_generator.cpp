// Serves the events of a recording as a DV stream over loopback, at a constant rate.
//
//   stream_generator RECORDING MILLION_EVENTS_PER_S SECONDS [PACKET_MS]
//
// Prints the port on which it listens. Sends uncompressed packets of PACKET_MS (1) to the first client, each when it is due.
// Prints one line of JSON at the end: what was sent, and the largest delay of a packet. It drops nothing, so a slow client delays
// it.

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "repeated_events.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::bench {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Returns false if the client has closed the connection.
bool send_all(int socket, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

events::FileDescriptor first_client() {
  const events::FileDescriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(listener.number(), reinterpret_cast<sockaddr*>(&address), length) != 0 || ::listen(listener.number(), 1) != 0 ||
      ::getsockname(listener.number(), reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    throw Error(std::string("stream_generator: cannot listen (") + std::strerror(errno) + "); expected a free port");
  }
  fmt::print("{}\n", ntohs(address.sin_port));
  std::fflush(stdout);
  events::FileDescriptor client(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
  const int at_once = 1;  // else small packets are held back for up to 40 ms
  ::setsockopt(client.number(), IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
  if (!client.is_open())
    throw Error(std::string("stream_generator: no client (") + std::strerror(errno) + "); expected a connection");
  return client;
}

void serve(const std::string& file, double million_per_s, int seconds, int packet_ms) {
  events::RecordingReader recording(file);
  events::Stream stream = events::event_stream_declaration(
      events::event_stream(recording).size.value_or(events::SensorSize{640, 480}), "DVXplorer_BENCH000");
  const auto in_packet = static_cast<std::size_t>(1000 * packet_ms * million_per_s);
  RepeatedEvents repeated(file, in_packet, packet_ms, camera_time(1'700'000'000'000'000));
  const std::size_t packet_header = 8, head = packet_header + events::event_packet_head;
  std::vector<std::byte> packet(head + in_packet * sizeof(events::Event));
  const auto payload = static_cast<std::int32_t>(packet.size() - packet_header);
  std::memcpy(packet.data() + 4, &payload, sizeof payload);
  events::write_event_packet_head(packet.data() + packet_header, in_packet);

  const events::FileDescriptor client = first_client();
  const std::string header = events::header_image(events::Compression::none, std::span(&stream, 1)).bytes;
  bool there = send_all(client.number(), std::as_bytes(std::span(header)));

  const auto begin = Clock::now();
  Clock::duration latest{};
  std::uint64_t sent = 0;
  for (int i = 0; i < 1000 * seconds / packet_ms && there; ++i) {
    const std::span<const events::Event> events = repeated.next();
    std::memcpy(packet.data() + head, events.data(), events.size_bytes());
    const auto due = begin + milliseconds(i * packet_ms);
    std::this_thread::sleep_until(due);
    there = send_all(client.number(), packet);
    if (there) sent += in_packet;
    latest = std::max(latest, Clock::now() - due);
  }
  const double took = std::chrono::duration<double>(Clock::now() - begin).count();
  fmt::print("{{\"events\": {}, \"seconds\": {:.3f}, \"latest_ms\": {:.1f}, \"client_left\": {}}}\n", sent, took,
             std::chrono::duration<double, std::milli>(latest).count(), !there);
}

}  // namespace
}  // namespace tactile::bench

int main(int argc, char** argv) {
  try {
    const int packet_ms = argc == 5 ? std::stoi(argv[4]) : 1;
    if (argc < 4 || argc > 5 || packet_ms < 1)
      throw tactile::Error("stream_generator: expected RECORDING MILLION_EVENTS_PER_S SECONDS [PACKET_MS]");
    tactile::bench::serve(argv[1], std::stod(argv[2]), std::stoi(argv[3]), packet_ms);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
