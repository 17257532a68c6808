#pragma once

#include <filesystem>

namespace tactile {

/// Only one at a time holds a folder: a second one waits, in this process or another. It ends with its owner, also with one that
/// is killed. No file is made for it. A folder that does not exist, or a disk without locks, gives a lock that excludes no one.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int folder_ = -1;
};

}  // namespace tactile
