#pragma once

#include <string>

#include "tactile/network/network_address.hpp"

namespace tactile {

/// The one camera that is there, else the stream that DV and its like serve. @throws Error  that begins with `command`, if there
/// is neither
std::string usual_source(const std::string& command);

/// `HOST` or `HOST:PORT` of --robot; an IPv6 address with a port in brackets. @throws Error  if it is neither
NetworkAddress robot_address(const std::string& text);

}  // namespace tactile
