#pragma once

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

namespace tactile::test {

/// A file or folder among recordings of real devices, which are not part of this project. TACTILE_RECORDINGS lists the folders
/// that may hold it, separated by colons. Empty if none does: then the test is skipped.
inline std::filesystem::path real_recording(const std::filesystem::path& name) {
  const char* listed = std::getenv("TACTILE_RECORDINGS");
  std::istringstream folders(listed == nullptr ? "" : listed);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && std::filesystem::exists(folder / name)) return folder / name;
  }
  return {};
}

inline std::string not_tested_without(const std::filesystem::path& name) {
  return "NOT TESTED: TACTILE_RECORDINGS lists no folder that holds " + name.string();
}

}  // namespace tactile::test
