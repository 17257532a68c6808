#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tactile::cli {

/// The man page of the program or of one of its commands, in roff. It is made from the same declarations as the help.
/// @param app  the program, or a command that `listed_commands` gives
/// Source: man(7), groff_man(7).
std::string manual_page(const CLI::App& app);

/// The name of its page: "tactile", "tactile-label".
std::string page_name(const CLI::App& app);

}  // namespace tactile::cli
