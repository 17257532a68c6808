#pragma once

#include <asio.hpp>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "tactile/transport/dv/dv_stream_packets.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::transport {

/// The clients of a server: accepts them, and sends each the shared packets of its queue. One thread serves all of them.
class DvStreamClients {
 public:
  /// Listens. @param header  what every client receives first
  /// @throws Error  if it cannot listen at `address`, or an option is 0
  DvStreamClients(const NetworkAddress& address, const DvStreamServerOptions& options, SharedPacket header);
  ~DvStreamClients();  ///< closes every connection, removes the socket's file
  DvStreamClients(const DvStreamClients&) = delete;
  DvStreamClients& operator=(const DvStreamClients&) = delete;

  const NetworkAddress& address() const { return address_; }  ///< with the port that it listens on
  std::size_t count() const;
  std::uint64_t joined() const;
  std::uint64_t dropped() const;

  /// Queues `packet` for every client, and drops those whose queue is full.
  void send(const SharedPacket& packet);
  bool wait_for_room(std::chrono::milliseconds patience, const std::function<bool()>& stop);  ///< as `DvStreamServer` has it
  void drain(std::chrono::milliseconds patience);                                             ///< as `DvStreamServer` has it

 private:
  using StreamProtocol = asio::generic::stream_protocol;

  /// Only the server's thread uses the socket; the mutex guards the rest.
  struct Client {
    Client(StreamProtocol::socket connected, std::string called) : socket(std::move(connected)), name(std::move(called)) {}

    StreamProtocol::socket socket;
    std::string name;
    std::deque<SharedPacket> queue;
    std::size_t queued = 0;   ///< [B] in the queue that the system has not taken yet
    std::size_t sent = 0;     ///< [B] of the queue's first packet that the system has taken
    bool writing = false;     ///< a write is in progress
    bool gone = false;        ///< left or dropped
    std::uint64_t taken = 0;  ///< [B] in total
    std::byte ignored{};      ///< receives a byte that the client must not send
  };
  using ClientPointer = std::shared_ptr<Client>;

  std::vector<StreamProtocol::endpoint> endpoints();
  void listen();
  void run();
  void accept();
  void add(StreamProtocol::socket socket, const StreamProtocol::endpoint& peer);
  void watch(const ClientPointer& client);
  void write(const ClientPointer& client);
  void wrote(const ClientPointer& client, std::size_t bytes);
  void remove(const ClientPointer& client, const std::string& why, bool is_drop);
  void drop_soon(const ClientPointer& client, std::string why);
  void log(const std::string& text) const;

  NetworkAddress address_;
  DvStreamServerOptions options_;
  SharedPacket header_;

  asio::io_context context_;
  asio::basic_socket_acceptor<StreamProtocol> listener_{context_};
  asio::steady_timer accept_again_{context_};
  bool owns_path_ = false;

  mutable std::mutex mutex_;
  std::condition_variable moved_;  ///< a client took bytes, or is gone
  std::list<ClientPointer> clients_;
  std::uint64_t joined_ = 0, dropped_ = 0;
  std::thread thread_;
};

}  // namespace tactile::transport
