#pragma once

#include <string>

#include "tactile/transport/network_address.hpp"

namespace tactile::cli {

/// The only camera, else the stream at the address that DV uses.
/// @throws Error  that begins with `command`, if there is neither, or several cameras
std::string default_source(const std::string& command);

/// `HOST` or `HOST:PORT` of --robot; an IPv6 address with a port in brackets. @throws Error  if it is neither
transport::NetworkAddress robot_address(const std::string& text);

}  // namespace tactile::cli
