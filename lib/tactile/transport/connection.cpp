#include "tactile/transport/connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <asio.hpp>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <exception>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/transport/deadline.hpp"

namespace tactile::transport {
namespace {

constexpr microseconds clock_rounding{50};  // largest difference between the system's clock and the host's for one instant

using std::chrono::milliseconds;
using StreamSocket = asio::generic::stream_protocol::socket;
using Endpoint = asio::generic::stream_protocol::endpoint;

struct Names {
  std::vector<Endpoint> endpoints;
  std::error_code error;
};

/// Every address of the host. A request to a name server cannot be cancelled. Therefore a separate thread sends it, and is
/// detached if the answer takes too long.
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

/// Detects within half a minute that the server cannot be reached any more, such as after a pulled cable, although the client
/// sends nothing.
void enable_keepalive(StreamSocket& socket) {
  const auto set = [&](int level, int name, int value) {
    ::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 15);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

bool enable_arrival_times(StreamSocket& socket) {
  const int on = 1;
  return ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) == 0;
}

/// How long ago the bytes of `message` arrived, by the system's clock. The result is wrong if that clock is stepped meanwhile.
/// Nothing if the system did not report it.
std::optional<microseconds> age_of(msghdr& message) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec came{}, now{};
    std::memcpy(&came, CMSG_DATA(part), sizeof came);
    ::clock_gettime(CLOCK_REALTIME, &now);
    return microseconds{(now.tv_sec - came.tv_sec) * 1'000'000 + (now.tv_nsec - came.tv_nsec) / 1'000};
  }
  return std::nullopt;
}

/// True once the socket is ready for `what`, or has an error; false at the deadline.
bool wait_for(StreamSocket& socket, short what, SteadyClock::time_point deadline) {
  for (;;) {
    const microseconds left = left_until(deadline);
    const timespec at_most{.tv_sec = left.count() / 1'000'000, .tv_nsec = 1'000 * (left.count() % 1'000'000)};
    pollfd poll{.fd = socket.native_handle(), .events = what, .revents = 0};
    const int ready = ::ppoll(&poll, 1, &at_most, nullptr);
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
    if (left.count() == 0) return false;
  }
}

bool would_block(const std::error_code& error) {
  return error == asio::error::would_block || error == asio::error::try_again || error == asio::error::interrupted;
}

milliseconds whole_milliseconds_until(SteadyClock::time_point deadline) {
  return std::chrono::ceil<milliseconds>(left_until(deadline));
}

}  // namespace

struct Connection::State {
  NetworkAddress address;
  asio::io_context context;
  StreamSocket socket{context};
  bool reports_arrivals = false;
  std::optional<HostTime> arrived;
  HostTime empty_at{};  ///< when no further bytes were available

  void open(milliseconds patience);
  bool connect(const Endpoint& endpoint, milliseconds patience, std::error_code& error);
  std::optional<std::size_t> read(std::span<std::byte> bytes);
  [[noreturn]] void break_off(const std::error_code& why) const {
    throw Error(address.text() + ": the connection broke (" + why.message() + "); expected it to last");
  }
};

/// False if there was no answer within `patience`; else `error` holds the outcome.
bool Connection::State::connect(const Endpoint& endpoint, milliseconds patience, std::error_code& error) {
  bool answered = false;
  socket = StreamSocket(context);
  socket.async_connect(endpoint, [&](const std::error_code& outcome) {
    answered = true;
    error = outcome;
  });
  context.restart();
  context.run_for(patience);
  context.poll();  // an answer that came in time counts, even if this thread reads it late
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
              : endpoints_of(address, whole_milliseconds_until(deadline));
  std::string why;
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    // Each remaining address has an equal share of the remaining time.
    const milliseconds share = whole_milliseconds_until(deadline) / static_cast<int>(endpoints.size() - i);
    std::error_code error;
    const bool answered = connect(endpoints[i], share, error);
    if (answered && !error) {
      socket.non_blocking(true);
      if (is_unix) return;
      enable_keepalive(socket);
      reports_arrivals = enable_arrival_times(socket);
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

/// Reads what is available, as `Connection::receive` returns it, and when it arrived.
std::optional<std::size_t> Connection::State::read(std::span<std::byte> bytes) {
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(timespec))> times{};
  iovec part{.iov_base = bytes.data(), .iov_len = bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (reports_arrivals) {  // otherwise this room would accept file descriptors that a local server passes
    message.msg_control = times.data();
    message.msg_controllen = times.size();
  }
  const HostTime asked = host_now();
  const ssize_t got = ::recvmsg(socket.native_handle(), &message, 0);
  if (got == 0) return std::nullopt;
  if (got < 0) {
    const std::error_code error(errno, asio::error::get_system_category());
    if (!would_block(error)) break_off(error);
    empty_at = asked;
    return 0;
  }
  const auto age = age_of(message);
  const HostTime now = host_now();  // after the age: a pause in between can make the bytes seem late, but not early
  const HostTime earliest = std::min(std::max(empty_at, arrived.value_or(empty_at)), now);
  arrived.reset();
  // Bytes that seem older than the last read: the system's clock was stepped.
  if (age && now - *age >= earliest - clock_rounding) arrived = std::clamp(now - *age, earliest, now);
  if (static_cast<std::size_t>(got) < bytes.size()) empty_at = asked;
  return static_cast<std::size_t>(got);
}

std::optional<std::size_t> Connection::receive(std::span<std::byte> bytes, microseconds patience) {
  if (bytes.empty()) return 0;
  std::optional<SteadyClock::time_point> deadline;
  for (;;) {
    const auto got = state_->read(bytes);
    if (got != std::size_t{0} || patience <= microseconds{0}) return got;
    if (!deadline) deadline = deadline_after(patience);
    if (!wait_for(state_->socket, POLLIN, *deadline)) return 0;
  }
}

std::optional<HostTime> Connection::arrived() const { return state_->arrived; }
bool Connection::reports_arrivals() const { return state_->reports_arrivals; }

void Connection::send(std::span<const std::byte> bytes, milliseconds patience) {
  const SteadyClock::time_point deadline = deadline_after(patience);
  while (!bytes.empty()) {
    std::error_code error;
    const std::size_t put = state_->socket.write_some(asio::buffer(bytes.data(), bytes.size()), error);
    if (!error) {
      bytes = bytes.subspan(put);
      continue;
    }
    if (!would_block(error)) state_->break_off(error);
    if (!wait_for(state_->socket, POLLOUT, deadline)) {
      throw Error(state_->address.text() + ": the server accepted no bytes for " + seconds_text(patience) +
                  "; expected it to read them");
    }
  }
}

}  // namespace tactile::transport
