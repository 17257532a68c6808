#pragma once

#include <filesystem>
#include <string>

namespace tactile {

/// Keeps others of the same kind out of a folder while it lives.
class FolderLock {
 public:
  /// Makes the folder where it is missing.
  /// @param command  that works in it, "tactile reproduce"
  /// @throws Error  if it cannot be written, or another is at work in it
  FolderLock(const std::filesystem::path& folder, const std::string& command);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace tactile
