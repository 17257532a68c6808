#include "tactile/transport/network_address.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::transport {
namespace {

constexpr std::string_view tcp_prefix = "tcp://";
constexpr std::string_view unix_prefix = "unix:";
constexpr std::size_t longest_socket_path = 107;  ///< sockaddr_un has 108 bytes, the last one is 0 [B]

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw Error("address '" + std::string(text) + "': " + std::string(why));
}

bool is_plain(char c) { return c > ' ' && c < 127 && c != '[' && c != ']' && c != '/'; }

NetworkAddress tcp_address(std::string_view text) {
  const std::string_view rest = text.substr(tcp_prefix.size());
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos) refuse(text, "has no port; expected tcp://host:port");
  std::string_view host = rest.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    if (host.find(':') == std::string_view::npos)
      refuse(text, "has a name in brackets; expected an IPv6 address there, such as [::1]");
  } else if (host.find(':') != std::string_view::npos) {
    refuse(text, "has more than one colon; expected an IPv6 address in brackets, such as tcp://[::1]:7777");
  }
  if (host.empty()) refuse(text, "has no host; expected tcp://host:port");
  if (!std::all_of(host.begin(), host.end(), is_plain))
    refuse(text, "has characters that no host name may have; expected tcp://host:port");
  const std::string_view digits = rest.substr(colon + 1);
  const auto port = whole_number_in(digits);
  if (!port || *port < 1 || *port > 65535) refuse(text, "has no port of 1 to 65535; expected tcp://host:port");
  NetworkAddress address;
  address.kind = NetworkAddress::Kind::tcp;
  address.host = host;
  address.port = static_cast<std::uint16_t>(*port);
  return address;
}

NetworkAddress unix_address(std::string_view text) {
  const std::string_view path = text.substr(unix_prefix.size());
  if (path.empty()) refuse(text, "has no path; expected unix:PATH");
  if (path.size() > longest_socket_path)
    refuse(text, "has a path of " + std::to_string(path.size()) + " bytes; expected at most 107, the limit of a socket");
  if (path.find('\0') != std::string_view::npos) refuse(text, "has a zero byte in its path; expected unix:PATH");
  NetworkAddress address;
  address.kind = NetworkAddress::Kind::unix_socket;
  address.path = path;
  return address;
}

}  // namespace

std::string NetworkAddress::text() const {
  if (kind == Kind::unix_socket) return std::string(unix_prefix) + path.string();
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return std::string(tcp_prefix) + (is_ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

NetworkAddress network_address(std::string_view text) {
  if (text.starts_with(tcp_prefix)) return tcp_address(text);
  if (text.starts_with(unix_prefix)) return unix_address(text);
  refuse(text, "is no address; expected tcp://host:port or unix:PATH");
}

}  // namespace tactile::transport
