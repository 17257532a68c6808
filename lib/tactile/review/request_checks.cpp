#include "tactile/review/request_checks.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <sys/random.h>

#include <array>
#include <cstddef>

#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"

namespace tactile::review {
namespace {

struct HostAndPort {
  std::string host;  ///< in lower case, without brackets
  std::string port;  ///< empty: the usual one, 80
};

HostAndPort divided(std::string_view text) {
  const std::size_t bracket = text.rfind(']');
  const std::size_t colon = text.rfind(':');
  HostAndPort result;
  if (colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)) {
    result.port = text.substr(colon + 1);
    text = text.substr(0, colon);
  }
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') text = text.substr(1, text.size() - 2);
  result.host = lower_case(text);
  return result;
}

bool is_address(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, host.c_str(), address.data()) == 1 || inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

}  // namespace

bool is_loopback(std::string_view host) {
  const std::string name = lower_case(host);
  return name == "localhost" || name == "::1" || name == "127.0.0.1";
}

bool is_any_address(std::string_view host) { return host == "0.0.0.0" || host == "::"; }

std::string why_foreign(const RequestOrigin& from, std::string_view served, std::uint16_t port, std::string_view machine) {
  const HostAndPort asked = divided(from.host);
  const bool is_port = asked.port == std::to_string(port) || (asked.port.empty() && port == 80);
  const bool is_name = is_loopback(asked.host) || asked.host == lower_case(served) ||
                       (is_any_address(served) && (is_address(asked.host) || asked.host == lower_case(machine)));
  if (!is_port || !is_name)
    return fmt::format("the request is for the host {}; expected the address that 'tactile' printed", shown_text(from.host));
  if (!from.origin.empty() && lower_case(from.origin) != "http://" + lower_case(from.host))
    return fmt::format("the request comes from {}; expected this page itself", shown_text(from.origin));
  if (!from.sec_fetch_site.empty() && from.sec_fetch_site != "same-origin" && from.sec_fetch_site != "none")
    return "the request comes from another site; expected this page itself";
  return {};
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("the system gives no random numbers for a token; expected getrandom to work");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_secret(std::string_view given, std::string_view expected) {
  if (given.size() != expected.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference =
        static_cast<unsigned char>(difference | (static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(expected[i])));
  return difference == 0;
}

std::string cookie_in(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    const std::string_view cookie = trimmed(header.substr(0, end));
    if (cookie.size() > name.size() && cookie.starts_with(name) && cookie[name.size()] == '=')
      return std::string(cookie.substr(name.size() + 1));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return {};
}

}  // namespace tactile::review
