#include "tactile/core/renaming.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tactile {
namespace fs = std::filesystem;
namespace {

bool has_entry(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(path, unknown));
}

int result_of(int call) { return call == 0 ? 0 : errno; }
int rename_with(const fs::path& from, const fs::path& to, unsigned flags) {
  return result_of(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags));
}
/// Network file systems may not support the flags of renameat2, old kernels not the call.
bool is_unsupported(int error) { return error == EINVAL || error == ENOSYS || error == EOPNOTSUPP; }

}  // namespace

int rename_if_free(const fs::path& from, const fs::path& to) {
  const int error = rename_with(from, to, RENAME_NOREPLACE);
  if (!is_unsupported(error)) return error;
  if (has_entry(to)) return EEXIST;
  if (!fs::is_directory(from)) {
    const int linked = result_of(::link(from.c_str(), to.c_str()));  // a second name: fails if `to` exists
    if (linked == 0) return result_of(::unlink(from.c_str()));
    if (linked != EPERM && linked != EOPNOTSUPP) return linked;
  }
  const int renamed = result_of(::rename(from.c_str(), to.c_str()));
  return renamed == ENOTEMPTY || renamed == ENOTDIR ? EEXIST : renamed;
}

int exchange_folders(const fs::path& from, const fs::path& to) {
  for (;;) {
    if (has_entry(to) && !fs::is_directory(to)) return ENOTDIR;
    int error = rename_with(from, to, RENAME_EXCHANGE);
    if (error == ENOENT) {  // `to` does not exist, unless another process is faster
      error = rename_if_free(from, to);
      if (error == EEXIST) continue;
    }
    if (!is_unsupported(error)) return error;
    // Not in one step: the old folder has a temporary name that is never removed as a leftover.
    const fs::path aside = to.parent_path() / ("." + to.filename().string() + ".replaced");
    std::error_code failed;
    fs::rename(to, aside, failed);
    if (failed) return failed.value();
    fs::rename(from, to, failed);
    if (failed) {
      const int reason = failed.value();
      fs::rename(aside, to, failed);
      return reason;
    }
    fs::rename(aside, from, failed);
    return failed.value();
  }
}

int replace_file(const fs::path& from, const fs::path& to) { return result_of(::rename(from.c_str(), to.c_str())); }

}  // namespace tactile
