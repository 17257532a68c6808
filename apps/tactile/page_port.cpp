#include "page_port.hpp"

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"

namespace tactile::cli {

Option add_page_option(Command& command, const std::string& name, std::string& port, const std::string& meaning) {
  return command.add_option(name, port, meaning).value_is_optional("7791").type_name("PORT");
}

std::uint16_t page_port(const std::string& name, const std::string& port) {
  const auto number = whole_number_in(port);
  if (!number || *number < 0 || *number > 65'535)
    throw Error(name + " " + shown_text(port) + ": is no port; expected 0 to 65535");
  return static_cast<std::uint16_t>(*number);
}

}  // namespace tactile::cli
