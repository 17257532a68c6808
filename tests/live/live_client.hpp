#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "review/page_client.hpp"
#include "support/comes_true.hpp"

namespace tactile::test {

/// A browser that listens to a live page.
class LiveClient {
 public:
  explicit LiveClient(std::uint16_t port) : connection_(port) {
    connection_.send(request_text(port, "GET /api/live", "Connection: close\r\n"));
    head_ = connection_.receive();
  }

  const Answer& head() const { return head_; }

  /// The next message; null if the stream has ended.
  nlohmann::json next() {
    if (connection_.receive_until("data: ").empty()) return {};
    const std::string line = connection_.receive_until("\n");
    return line.empty() ? nlohmann::json() : nlohmann::json::parse(line);
  }

  /// The first message for which `is_it` holds; null if there is none.
  template <class IsIt>
  nlohmann::json next_where(const IsIt& is_it) {
    const auto begun = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begun < long_enough) {
      nlohmann::json message = next();
      if (message.is_null() || is_it(message)) return message;
    }
    return {};
  }

 private:
  PageConnection connection_;
  Answer head_;
};

inline std::uint16_t port_in(const std::string& url) {
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
}

}  // namespace tactile::test
