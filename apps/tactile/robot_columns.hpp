#pragma once

#include <string>

#include "options.hpp"

namespace tactile::cli {

/// Declares `--robot-columns`, of every command that reads a robot log. @param columns  must outlive the command
Option add_robot_columns_option(Command& command, std::string& columns);

}  // namespace tactile::cli
