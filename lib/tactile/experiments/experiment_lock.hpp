#pragma once

#include <filesystem>
#include <string>

namespace tactile::experiments {

/// Locks a folder while it exists, so that two experiments never write to the same one.
class FolderLock {
 public:
  /// Makes the folder if it is missing.
  /// @param command  the one that works in it, "tactile reproduce"; named in the error
  /// @throws Error  if the folder cannot be written, or another process has locked it
  FolderLock(const std::filesystem::path& folder, const std::string& command);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace tactile::experiments
