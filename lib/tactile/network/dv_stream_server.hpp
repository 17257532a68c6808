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
#include "tactile/network/network_address.hpp"

namespace tactile {

struct DvStreamServerOptions {
  Compression compression = Compression::none;
  std::size_t client_queue = std::size_t{64} << 20;  ///< [B] a client that lags behind by more is dropped, > 0
  std::size_t clients = 10;                          ///< at once; further ones are closed at once, > 0
  /// Told, from the server's own thread, what became of clients: "127.0.0.1:51234 joined", "… dropped: 64 MB behind".
  std::function<void(const std::string&)> log;
};

/// Serves one stream to several clients, as dv-processing's `NetworkWriter` does. Packets go to every client that is there; one
/// that comes later joins at the next packet. Clients never wait for each other: each has a queue of its own of shared packets.
class DvStreamServer {
 public:
  /// Listens; port 0 takes a free one. @throws Error if it cannot, or the stream lacks what the vendor's reader demands
  DvStreamServer(const NetworkAddress& address, Stream stream, DvStreamServerOptions options = {});
  ~DvStreamServer();  ///< closes every connection, removes the socket's file
  DvStreamServer(const DvStreamServer&) = delete;
  DvStreamServer& operator=(const DvStreamServer&) = delete;

  const NetworkAddress& address() const;  ///< with the port that was taken
  std::size_t clients() const;
  std::uint64_t joined_clients() const;  ///< so far, those that are gone among them
  std::uint64_t dropped_clients() const;

  // One packet each; nothing is sent of empty ones. @throws Error if the stream holds another type or a packet exceeds the limit
  void send(std::span<const Event> events);
  void send(std::span<const ImuSample> samples);
  void send(std::span<const Trigger> triggers);
  void send(const Frame& frame);

  /// Waits while any client's queue is more than half full, for a source that can be faster than every client. A client that
  /// takes nothing at all for `patience` meanwhile is dropped. False if `stop` told so before.
  bool wait_for_room(std::chrono::milliseconds patience, const std::function<bool()>& stop = {});

  /// Waits until everything queued is with the clients that keep up, at most `patience`.
  void drain(std::chrono::milliseconds patience);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
