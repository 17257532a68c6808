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

/// The contents of a file; empty if it cannot be read.
inline std::string text_in_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Runs `command` in a shell, in the folder `in`, and returns what it printed.
inline CommandResult run_shell(const std::string& command, const std::filesystem::path& in = ".") {
  const TemporaryFolder folder;
  const std::string whole = "cd '" + in.string() + "' && ( " + command + " ) >'" + (folder / "out").string() + "' 2>'" +
                            (folder / "err").string() + "' </dev/null";
  const int status = std::system(whole.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_in_file(folder / "out"),
          text_in_file(folder / "err")};
}

/// Runs the built `tactile` with arguments as they are written in a shell.
inline CommandResult run_tactile(const std::string& arguments, const std::filesystem::path& in = ".") {
  return run_shell(std::string("'") + test::tactile_binary + "' " + arguments, in);
}

}  // namespace tactile::test
