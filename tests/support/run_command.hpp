#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::test {

struct CommandResult {
  int exit_code = -1;
  std::string out;  ///< stdout
  std::string err;  ///< stderr
};

/// Runs `command` in a shell, in the folder `in` where one is given, and returns what it printed.
inline CommandResult run_shell(const std::string& command, const std::filesystem::path& in = ".") {
  const TemporaryFolder folder;
  const auto text_of = [](const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  };
  const std::string whole = "cd '" + in.string() + "' && ( " + command + " ) >'" + (folder / "out").string() + "' 2>'" +
                            (folder / "err").string() + "' </dev/null";
  const int status = std::system(whole.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(folder / "out"), text_of(folder / "err")};
}

/// Runs the built `tactile` with these arguments, written as for a shell.
inline CommandResult run_tactile(const std::string& arguments, const std::filesystem::path& in = ".") {
  return run_shell(std::string("'") + test::tactile_binary + "' " + arguments, in);
}

}  // namespace tactile::test
