#include "tactile/core/command_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "tactile/core/error.hpp"
#include "tactile/core/make_folders.hpp"

namespace tactile {

CommandLock::CommandLock(const std::filesystem::path& folder, const std::string& command, const std::string& file)
    : path_(folder / file), made_folder_(!std::filesystem::exists(folder)) {
  make_folders(folder);
  // The command before may remove the file until it is locked: then the next one is created.
  for (;;) {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file_ < 0) return;
    int taken = 0;
    do {
      taken = ::flock(file_, LOCK_EX | LOCK_NB);
    } while (taken != 0 && errno == EINTR);
    if (taken != 0 && errno == EWOULDBLOCK) {
      ::close(file_);
      throw Error(folder.string() + ": another '" + command +
                  "' is writing to this folder; wait until it has ended, or use another folder");
    }
    struct stat status {};
    if (::fstat(file_, &status) != 0 || status.st_nlink > 0) return;
    ::close(file_);
  }
}

CommandLock::~CommandLock() {
  if (file_ < 0) return;
  ::unlink(path_.c_str());                                 // before the lock ends: a later command must not lose its own file
  if (made_folder_) ::rmdir(path_.parent_path().c_str());  // only if it is empty
  ::close(file_);
  remove_empty_made_folders(path_.parent_path());
}

}  // namespace tactile
