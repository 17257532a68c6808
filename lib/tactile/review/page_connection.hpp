#pragma once

#include <httplib.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <string>

#include "tactile/review/page_server.hpp"

namespace tactile::review {

/// A client's connection. httplib limits each read and write by itself; this limits a whole request, by its time and its bytes,
/// so that a client that sends a byte now and then holds nothing.
class Connection final : public httplib::Stream {
 public:
  Connection(int socket, const PageServerOptions& options, const std::atomic<bool>& ends)
      : socket_(socket), options_(options), ends_(ends) {}

  /// Waits for the first byte of a request; false if none comes.
  bool wait_for_request() {
    deadline_ = SteadyClock::now() + options_.idle;
    left_ = most_head;
    if (begin_ < end_) return true;
    if (!wait(POLLIN)) return false;
    deadline_ = SteadyClock::now() + options_.request_within;
    return true;
  }

  bool is_readable() const override { return begin_ < end_ || wait_for(POLLIN, 0) > 0; }
  bool is_writable() const override { return waits_for_room_ || wait_for(POLLOUT, 0) > 0; }

  ssize_t read(char* bytes, std::size_t size) override {
    if (left_ == 0) return -1;
    if (begin_ == end_ && !fill()) return -1;
    const std::size_t count = std::min({size, end_ - begin_, left_});
    std::copy_n(buffer_.data() + begin_, count, bytes);
    begin_ += count;
    left_ -= count;
    return static_cast<ssize_t>(count);
  }

  ssize_t write(const char* bytes, std::size_t size) override {
    deadline_ = SteadyClock::now() + options_.stall;
    if (!wait(POLLOUT)) return -1;
    return ::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return socket_; }

  /// The answer has parts: a client that is slow to take them is waited for.
  void begin_parts() { waits_for_room_ = true; }

  /// Waits until the client takes more; false if it has left or takes nothing for `stall`, or the server ends.
  bool wait_for_room() {
    deadline_ = SteadyClock::now() + options_.stall;
    if (!wait(static_cast<short>(POLLOUT | POLLRDHUP))) return false;
    pollfd one{.fd = socket_, .events = POLLRDHUP, .revents = 0};
    return ::poll(&one, 1, 0) == 0;
  }

  void take_body() { left_ = options_.most_body; }  ///< the request's head is read, and what follows is wanted

  /// The request was not read to its end, so that what follows it is no request.
  void close_after_this() { closes_ = true; }
  bool closes() const { return closes_; }

  /// Ends the connection. What the client still sends is taken for a moment, because closing at once would make it lose the
  /// answer.
  void end() {
    ::shutdown(socket_, SHUT_WR);
    constexpr std::size_t most = 1 << 20;
    deadline_ = SteadyClock::now() + milliseconds{closes_ ? 500 : 0};
    for (std::size_t taken = 0; taken < most && wait(POLLIN);) {
      const ssize_t count = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (count <= 0) break;
      taken += static_cast<std::size_t>(count);
    }
    ::close(socket_);
  }

 private:
  using SteadyClock = std::chrono::steady_clock;
  using milliseconds = std::chrono::milliseconds;

  static constexpr std::size_t most_head = 32'768;   ///< [B] of a request before its body
  static constexpr milliseconds look_up_every{100};  ///< whether the server ends

  int wait_for(short what, int ms) const {
    pollfd one{.fd = socket_, .events = what, .revents = 0};
    return ::poll(&one, 1, ms);
  }

  bool wait(short what) {
    while (!ends_) {
      const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - SteadyClock::now());
      if (left.count() < 0) return false;
      const int ready = wait_for(what, static_cast<int>(std::min(left, look_up_every).count()));
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) return false;
      if (ready == 0 && left.count() == 0) return false;
    }
    return false;
  }

  bool fill() {
    if (!wait(POLLIN)) return false;
    const ssize_t count = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (count <= 0) return false;
    begin_ = 0;
    end_ = static_cast<std::size_t>(count);
    return true;
  }

  int socket_;
  const PageServerOptions& options_;
  const std::atomic<bool>& ends_;
  SteadyClock::time_point deadline_{};
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0;
  std::size_t left_ = 0;  ///< [B] that this request may still have
  bool closes_ = false, waits_for_room_ = false;
};

}  // namespace tactile::review
