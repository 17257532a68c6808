#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tactile::cli {

struct UsageError {
  std::string sentence;  ///< which argument, what is wrong with it, what is right
  int exit_code = 0;     ///< CLI11's
};

/// What is wrong with a command line that `app` rejected.
UsageError usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace tactile::cli
