#include "tactile/network/connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <asio.hpp>
#include <cerrno>
#include <exception>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/network/deadline.hpp"

namespace tactile {
namespace {

using std::chrono::milliseconds;
using StreamSocket = asio::generic::stream_protocol::socket;
using Endpoint = asio::generic::stream_protocol::endpoint;

struct Names {
  std::vector<Endpoint> endpoints;
  std::error_code error;
};

/// Every address of the host. Asking a name server cannot be called off, so a thread of its own does it, which is left behind
/// where it takes too long.
std::vector<Endpoint> endpoints_of(const NetworkAddress& address, milliseconds patience) {
  std::error_code error;
  const asio::ip::address literal = asio::ip::make_address(address.host, error);
  if (!error) return {asio::ip::tcp::endpoint(literal, address.port)};

  std::promise<Names> promise;
  std::future<Names> future = promise.get_future();
  std::thread([promise = std::move(promise), host = address.host, port = std::to_string(address.port)]() mutable {
    try {
      Names names;
      asio::io_context context;
      asio::ip::tcp::resolver resolver(context);
      for (const auto& found : resolver.resolve(host, port, asio::ip::resolver_base::numeric_service, names.error)) {
        names.endpoints.emplace_back(found.endpoint());
      }
      promise.set_value(std::move(names));
    } catch (const std::exception&) {
      promise.set_exception(std::current_exception());
    }
  }).detach();
  if (future.wait_for(patience) != std::future_status::ready) {
    throw Error(address.text() + ": no answer from the name service about '" + address.host + "' within " +
                seconds_text(patience) + "; expected the name of a host, or its IP address");
  }
  Names names = future.get();
  if (names.error || names.endpoints.empty()) {
    throw Error(address.text() + ": there is no host '" + address.host + "' (" +
                (names.error ? names.error.message() : "no address") + "); expected the name of a host, or its IP address");
  }
  return std::move(names.endpoints);
}

/// A server that vanished without a word, by a pulled cable, is noticed within half a minute although nothing is ever sent.
void watch_the_line(StreamSocket& socket) {
  const auto set = [&](int level, int name, int value) {
    ::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 15);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

/// True once the socket is ready for `what`, or has an error to tell; false at the deadline.
bool wait_for(StreamSocket& socket, short what, SteadyClock::time_point deadline) {
  for (;;) {
    const milliseconds left = left_until(deadline);
    pollfd poll{.fd = socket.native_handle(), .events = what, .revents = 0};
    const int ready = ::poll(&poll, 1, static_cast<int>(left.count()));
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
    if (left.count() == 0) return false;
  }
}

bool would_block(const std::error_code& error) {
  return error == asio::error::would_block || error == asio::error::try_again || error == asio::error::interrupted;
}

}  // namespace

struct Connection::State {
  NetworkAddress address;
  asio::io_context context;
  StreamSocket socket{context};

  void open(milliseconds patience);
  bool connect(const Endpoint& endpoint, milliseconds patience, std::error_code& error);
};

/// False if there was no answer within `patience`; else `error` tells how it went.
bool Connection::State::connect(const Endpoint& endpoint, milliseconds patience, std::error_code& error) {
  bool answered = false;
  socket = StreamSocket(context);
  socket.async_connect(endpoint, [&](const std::error_code& outcome) {
    answered = true;
    error = outcome;
  });
  context.restart();
  context.run_for(patience);
  if (answered) return true;
  std::error_code ignored;
  socket.close(ignored);
  context.run();  // the handler refers to this frame
  return false;
}

void Connection::State::open(milliseconds patience) {
  const bool is_unix = address.kind == NetworkAddress::Kind::unix_socket;
  const SteadyClock::time_point deadline = deadline_after(patience);
  const std::vector<Endpoint> endpoints =
      is_unix ? std::vector<Endpoint>{asio::local::stream_protocol::endpoint(address.path.string())}
              : endpoints_of(address, left_until(deadline));
  std::string why;
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    // An address that does not answer leaves their share to the others.
    const milliseconds share = left_until(deadline) / static_cast<int>(endpoints.size() - i);
    std::error_code error;
    const bool answered = connect(endpoints[i], share, error);
    if (answered && !error) {
      socket.non_blocking(true);
      if (!is_unix) watch_the_line(socket);
      return;
    }
    why = answered ? error.message() : "no answer within " + seconds_text(patience);
  }
  throw Error(address.text() + ": cannot be connected to (" + why + "); expected a server that listens there");
}

Connection::Connection(const NetworkAddress& address, milliseconds patience) : state_(std::make_unique<State>()) {
  state_->address = address;
  try {
    state_->open(patience);
  } catch (const std::system_error& e) {
    throw Error(address.text() + ": cannot be connected to (" + e.what() + "); expected a server that listens there");
  }
}
Connection::~Connection() = default;
Connection::Connection(Connection&&) noexcept = default;
Connection& Connection::operator=(Connection&&) noexcept = default;

const NetworkAddress& Connection::address() const { return state_->address; }

std::optional<std::size_t> Connection::receive(std::span<std::byte> bytes, milliseconds patience) {
  if (bytes.empty()) return 0;
  const SteadyClock::time_point deadline = deadline_after(patience);
  for (;;) {
    std::error_code error;
    const std::size_t got = state_->socket.read_some(asio::buffer(bytes.data(), bytes.size()), error);
    if (!error) return got;
    if (error == asio::error::eof) return std::nullopt;
    if (!would_block(error)) {
      throw Error(state_->address.text() + ": the connection broke (" + error.message() + "); expected it to last");
    }
    if (!wait_for(state_->socket, POLLIN, deadline)) return 0;
  }
}

void Connection::send(std::span<const std::byte> bytes, milliseconds patience) {
  const SteadyClock::time_point deadline = deadline_after(patience);
  while (!bytes.empty()) {
    std::error_code error;
    const std::size_t put = state_->socket.write_some(asio::buffer(bytes.data(), bytes.size()), error);
    if (!error) {
      bytes = bytes.subspan(put);
      continue;
    }
    if (!would_block(error)) {
      throw Error(state_->address.text() + ": the connection broke (" + error.message() + "); expected it to last");
    }
    if (!wait_for(state_->socket, POLLOUT, deadline)) {
      throw Error(state_->address.text() + ": the server took nothing for " + seconds_text(patience) +
                  "; expected it to read what it is sent");
    }
  }
}

}  // namespace tactile
