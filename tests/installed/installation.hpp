#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <set>
#include <string>

#include "support/paths.hpp"
#include "support/run_command.hpp"

namespace tactile::test {

/// Installs what is built. @param component  "program", "development", or nothing for both
inline CommandResult install_to(const std::filesystem::path& prefix, const std::string& component = "") {
  return run_shell(fmt::format("'{}' --install '{}' --prefix '{}' {}", cmake_program, build_folder, prefix.string(),
                               component.empty() ? "" : "--component " + component));
}

/// The files and links below a folder, relative to it.
inline std::set<std::string> files_below(const std::filesystem::path& folder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_directory()) files.insert(std::filesystem::relative(entry.path(), folder).string());
  }
  return files;
}

}  // namespace tactile::test
