#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tactile::transport {

/// Where a server listens: `tcp://host:port` or `unix:PATH`.
struct NetworkAddress {
  enum class Kind : std::uint8_t { tcp, unix_socket };
  Kind kind = Kind::tcp;
  std::string host;            ///< tcp: a name or a literal, IPv6 without brackets
  std::uint16_t port = 0;      ///< tcp
  std::filesystem::path path;  ///< unix_socket

  std::string text() const;  ///< as a user writes it: "tcp://127.0.0.1:7777", "tcp://[::1]:7777", "unix:/run/events"
};

/// @throws Error  if `text` is neither `tcp://host:port` with a port of 1 to 65535 nor `unix:PATH` with a path of 1 to 107 bytes
NetworkAddress network_address(std::string_view text);

}  // namespace tactile::transport
