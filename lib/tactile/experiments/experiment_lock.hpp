#pragma once

#include <filesystem>
#include <string>

namespace tactile::experiments {

/// Locks the output folder of an experiment while it exists, so that two never write to the same one. A second one gets an error
/// at once; with `tactile::FolderLock`, which lasts for moments, it waits.
class ExperimentLock {
 public:
  /// Makes the folder if it is missing.
  /// @param command  the one that works in it, "tactile reproduce"; named in the error
  /// @throws Error  if the folder cannot be written, or another process has locked it
  ExperimentLock(const std::filesystem::path& folder, const std::string& command);
  ~ExperimentLock();
  ExperimentLock(const ExperimentLock&) = delete;
  ExperimentLock& operator=(const ExperimentLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace tactile::experiments
