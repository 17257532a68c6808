#include "tactile/experiments/experiment_lock.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include "tactile/core/error.hpp"

namespace tactile::experiments {

ExperimentLock::ExperimentLock(const std::filesystem::path& folder, const std::string& command) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  file_ = ::open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) throw Error(folder.string() + ": cannot be written; expected a writable folder");
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(file_);
    throw Error(fmt::format("{}: another '{}' is running in it; expected only one, or another --out", folder.string(), command));
  }
}

ExperimentLock::~ExperimentLock() { ::close(file_); }

}  // namespace tactile::experiments
