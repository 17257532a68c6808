#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <asio.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "tactile/transport/network_address.hpp"

namespace tactile::test {

/// A server on loopback that does to its one client whatever a test wants, in a thread of its own.
class ScriptedServer {
 public:
  using Socket = asio::generic::stream_protocol::socket;
  using Script = std::function<void(Socket&)>;

  explicit ScriptedServer(Script script, const asio::generic::stream_protocol::endpoint& at =
                                             asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0))
      : listener_(context_, at.protocol()), script_(std::move(script)) {
    ::fcntl(listener_.native_handle(), F_SETFD, FD_CLOEXEC);  // a command that a test starts would keep it open
    listener_.bind(at);
    listener_.listen();
    if (at.protocol().family() == AF_UNIX) {
      address_.kind = transport::NetworkAddress::Kind::unix_socket;

      address_.path = reinterpret_cast<const sockaddr_un*>(at.data())->sun_path;
    } else {
      asio::ip::tcp::endpoint taken;
      socklen_t size = static_cast<socklen_t>(taken.capacity());
      ::getsockname(listener_.native_handle(), taken.data(), &size);
      taken.resize(size);
      address_.host = taken.address().to_string();
      address_.port = taken.port();
    }
    thread_ = std::thread([this] {
      std::error_code error;
      Socket client(context_);
      listener_.accept(client, error);
      if (!error) script_(client);
    });
  }
  ~ScriptedServer() {
    ::shutdown(listener_.native_handle(), SHUT_RDWR);  // wakes an accept that nobody came to
    thread_.join();
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  const transport::NetworkAddress& address() const { return address_; }

 private:
  asio::io_context context_;
  asio::basic_socket_acceptor<asio::generic::stream_protocol> listener_;
  Script script_;
  transport::NetworkAddress address_;
  std::thread thread_;
};

/// Sends all of `bytes`; a client that is gone is no failure of the server.
inline void send_all(ScriptedServer::Socket& client, const std::string& bytes) {
  std::error_code ignored;
  asio::write(client, asio::buffer(bytes), ignored);
}

/// What the client sends until it closes.
inline std::string until_closed(ScriptedServer::Socket& client) {
  std::string all;
  std::error_code error;
  asio::read(client, asio::dynamic_buffer(all), error);
  return all;
}

/// Closes with a reset, as a process that died does.
inline void reset(ScriptedServer::Socket& client) {
  client.set_option(asio::socket_base::linger(true, 0));
  client.close();
}

}  // namespace tactile::test
