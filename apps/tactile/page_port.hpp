#pragma once

#include <cstdint>
#include <string>

#include "options.hpp"

namespace tactile::cli {

/// An option that serves a live page: alone at port 7791, with a value at that port.
/// @param port  empty without the option
Option add_page_option(Command& command, const std::string& name, std::string& port, const std::string& meaning);

/// @throws Error  unless the value of the option is a port
std::uint16_t page_port(const std::string& name, const std::string& port);

}  // namespace tactile::cli
