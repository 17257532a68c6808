#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tactile/core/text.hpp"

// A client that sends what it is given, byte by byte: libraries refuse to send what a hostile one sends.
namespace tactile::test {

struct Answer {
  int status = 0;                              ///< 0: the connection ended without an answer
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;

  nlohmann::json json() const { return nlohmann::json::parse(body); }
};

class PageConnection {
 public:
  explicit PageConnection(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    const timeval longest{.tv_sec = 60, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof longest);
  }
  ~PageConnection() { ::close(socket_); }
  PageConnection(const PageConnection&) = delete;
  PageConnection& operator=(const PageConnection&) = delete;

  bool is_open() const { return is_open_; }
  bool send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
      if (count <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }

  /// The next answer on this connection.
  Answer receive() {
    Answer answer;
    std::size_t head = 0;
    while ((head = received_.find("\r\n\r\n")) == std::string::npos) {
      if (!take()) return answer;
    }
    std::string lines = received_.substr(0, head + 2);
    answer.status = std::atoi(lines.substr(lines.find(' ') + 1).c_str());
    for (std::size_t at = lines.find("\r\n") + 2, end = 0; (end = lines.find("\r\n", at)) != std::string::npos; at = end + 2) {
      const std::string line = lines.substr(at, end - at);
      const std::size_t colon = line.find(':');
      answer.headers[lower_case(line.substr(0, colon))] = std::string(trimmed(line.substr(colon + 1)));
    }
    const auto length = static_cast<std::size_t>(std::atoll(answer.headers["content-length"].c_str()));
    while (received_.size() < head + 4 + length && take()) {
    }
    answer.body = received_.substr(head + 4, length);
    received_.erase(0, std::min(received_.size(), head + 4 + length));
    return answer;
  }

  /// What comes after the answer's head, up to these words. Empty if the connection ends before them.
  std::string receive_until(std::string_view words) {
    std::size_t at = 0;
    while ((at = received_.find(words)) == std::string::npos) {
      if (!take()) return {};
    }
    const std::string text = received_.substr(0, at + words.size());
    received_.erase(0, at + words.size());
    return text;
  }

  /// Whether the server has ended the connection; waits for it.
  bool is_ended() {
    while (take()) received_.clear();
    return true;
  }

 private:
  bool take() {
    std::array<char, 65536> bytes{};
    const ssize_t count = ::recv(socket_, bytes.data(), bytes.size(), 0);
    if (count <= 0) return false;
    received_.append(bytes.data(), static_cast<std::size_t>(count));
    return true;
  }

  int socket_;
  bool is_open_ = false;
  std::string received_;
};

/// A request of this page, as a browser sends it. @param more  headers, each with its line end; may replace Host
inline std::string request_text(std::uint16_t port, const std::string& line, const std::string& more = "",
                                const std::string& body = "") {
  std::string text = line + " HTTP/1.1\r\n";
  if (more.find("Host:") == std::string::npos) text += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  return text + more + "\r\n" + body;
}

inline Answer get(std::uint16_t port, const std::string& path, const std::string& more = "") {
  PageConnection connection(port);
  connection.send(request_text(port, "GET " + path, more));
  return connection.receive();
}

inline Answer post(std::uint16_t port, const std::string& path, const std::string& body, const std::string& more = "") {
  PageConnection connection(port);
  connection.send(request_text(port, "POST " + path,
                               "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" + more,
                               body));
  return connection.receive();
}

}  // namespace tactile::test
