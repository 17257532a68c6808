#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Who may ask: the checks of a page's server, without sockets.
namespace tactile::review {

/// What a request says of its origin; empty where it lacks the header.
struct RequestOrigin {
  std::string host;            ///< "127.0.0.1:7790"
  std::string origin;          ///< "http://127.0.0.1:7790"
  std::string sec_fetch_site;  ///< "same-origin", "none", "cross-site", "same-site"
};

/// Whether the name of a host is this machine alone: "localhost", "127.0.0.1", "::1".
bool is_loopback(std::string_view host);

/// Whether the address stands for every address of this machine: "0.0.0.0", "::".
bool is_any_address(std::string_view host);

/// Why the request is refused; empty if it is not. A page of another site must not reach this server, not even by a name that it
/// lets point here: the host must be a loopback name or the `served` one (where every address is served: an address, or this
/// machine's name), with the port; the origin, if there is one, must be this host; and the browser must not call the request one
/// of another site.
std::string why_foreign(const RequestOrigin& from, std::string_view served, std::uint16_t port, std::string_view machine);

/// 128 random bits as 32 hexadecimal digits. @throws Error  if the system has none
std::string random_token();

/// Whether both are the same, in a time that depends on the lengths alone.
bool same_secret(std::string_view given, std::string_view expected);

/// The value of a cookie in the header `Cookie`; empty if there is none.
std::string cookie_in(std::string_view header, std::string_view name);

}  // namespace tactile::review
