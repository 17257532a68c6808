#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::transport {

struct DvStreamServerOptions {
  events::Compression compression = events::Compression::none;
  std::size_t client_queue = std::size_t{64} << 20;  ///< [B] a client with more unsent bytes is dropped, > 0
  std::size_t clients = 10;                          ///< at the same time, > 0; further ones are closed immediately
  /// Called on the server's thread when a client joins or leaves: "127.0.0.1:51234 joined", "… dropped: 64.0 MB unsent".
  std::function<void(const std::string&)> log;
};

/// Serves one stream to several clients, as dv-processing's `NetworkWriter` does. Every connected client receives each packet; a
/// new client starts with the next packet. Clients never wait for each other: each has its own queue of shared packets.
class DvStreamServer {
 public:
  /// Listens; port 0 selects a free port.
  /// @throws Error  if it cannot listen, or the stream lacks something that DV's reader needs
  DvStreamServer(const NetworkAddress& address, events::Stream stream, DvStreamServerOptions options = {});
  ~DvStreamServer();  ///< closes every connection, removes the socket's file
  DvStreamServer(const DvStreamServer&) = delete;
  DvStreamServer& operator=(const DvStreamServer&) = delete;

  const NetworkAddress& address() const;  ///< with the port that it listens on
  std::size_t clients() const;
  std::uint64_t joined_clients() const;  ///< so far, including those that left
  std::uint64_t dropped_clients() const;

  // Each sends one packet, or nothing if it is empty.
  // @throws Error  if the stream has another type, or the packet exceeds the limit
  void send(std::span<const events::Event> events);
  void send(std::span<const events::ImuSample> samples);
  void send(std::span<const events::Trigger> triggers);
  void send(const events::Frame& frame);

  /// Waits while any client's queue is more than half full, for a source that can be faster than every client. Drops a client
  /// that accepts no bytes for `patience` meanwhile. False if `stop` returned true.
  bool wait_for_room(std::chrono::milliseconds patience, const std::function<bool()>& stop = {});

  /// Waits until the queues of all clients are empty, at most `patience`.
  void drain(std::chrono::milliseconds patience);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::transport
