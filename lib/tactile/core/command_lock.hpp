#pragma once

#include <filesystem>
#include <string>

namespace tactile {

/// Keeps a folder for one command while it exists: a second one ends at once, instead of writing between the files of the first.
/// It ends with its owner, also with one that is killed. A hidden file in the folder holds it, and is removed at the end; the
/// next command takes the file that a killed one left. A folder that this made, and that is empty at the end, is removed. A
/// folder that cannot be written, or a disk without locks, excludes no one.
class CommandLock {
 public:
  /// Makes the folder if it is missing.
  /// @param command  the one that works in it, "tactile reproduce"; named in the error
  /// @param file  commands with locks of the same name exclude each other
  /// @throws Error  if another command has locked the folder, or the folder cannot be made
  CommandLock(const std::filesystem::path& folder, const std::string& command, const std::string& file = ".lock");
  ~CommandLock();
  CommandLock(const CommandLock&) = delete;
  CommandLock& operator=(const CommandLock&) = delete;

 private:
  std::filesystem::path path_;
  bool made_folder_ = false;
  int file_ = -1;
};

}  // namespace tactile
