#include "input_lines.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <thread>

namespace tactile::cli {

std::optional<std::string> InputLines::next(std::chrono::milliseconds patience) {
  if (auto line = buffered()) return line;
  if (ended_) {
    std::this_thread::sleep_for(patience);
    return {};
  }
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  if (::poll(&input, 1, static_cast<int>(patience.count())) <= 0) return {};
  std::array<char, 256> bytes{};
  const ssize_t got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  if (got < 0 && (errno == EINTR || errno == EAGAIN)) return {};
  if (got <= 0) {
    ended_ = true;
  } else {
    text_.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return buffered();
}

std::optional<std::string> InputLines::buffered() {
  const std::size_t end = text_.find('\n');
  if (end == std::string::npos) return {};
  std::string line = text_.substr(0, end);
  text_.erase(0, end + 1);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

}  // namespace tactile::cli
