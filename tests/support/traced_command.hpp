#pragma once

#include <fcntl.h>
#include <sys/syscall.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "support/traced_calls.hpp"

namespace tactile::test {

/// A file that a system call is about to touch.
struct TouchedFile {
  std::string name;      ///< without its folder
  bool by_name = false;  ///< true: opened, renamed or removed by its name; false: written or synced as an open file
};

/// How a traced command ended.
struct TracedEnd {
  bool killed = false;
  std::size_t calls = 0;  ///< that counted, before the end
  int exit_code = -1;     ///< if it was not killed
};

inline constexpr std::size_t never = std::numeric_limits<std::size_t>::max();

/// `tactile` under ptrace, which can be killed before any of the system calls that count. A call counts if it can change a file
/// for which `counts` returns true.
class TracedCommand {
 public:
  using Counts = std::function<bool(const TouchedFile&)>;

  /// Runs it in the folder `in` and kills it before the call with number `kill_at`, from 0, of those that count.
  /// @return nothing if this machine allows no tracing. @throws std::runtime_error if tracing fails later
  static std::optional<TracedEnd> run(const std::vector<std::string>& arguments, const std::filesystem::path& in,
                                      const Counts& counts, std::size_t kill_at = never) {
    std::vector<std::string> words{test::tactile_binary};
    words.insert(words.end(), arguments.begin(), arguments.end());
    TracedEnd end;
    const auto begins = [&](const TracedCall& call) {
      const std::vector<TouchedFile> files = files_of(call.thread, call.number, call.arguments.data());
      if (std::none_of(files.begin(), files.end(), counts)) return true;
      end.killed = end.calls == kill_at;
      if (!end.killed) ++end.calls;
      return !end.killed;
    };
    const std::optional<int> exit_code = trace_calls(words, in, begins, [](const TracedCall&) {});
    if (!exit_code) return std::nullopt;
    end.exit_code = *exit_code;
    return end;
  }

 private:
  /// Whether the call can change what is on the disk. A kill before any other call leaves the same as one before the next call
  /// that can.
  static bool changes_files(long call, const std::uint64_t* arguments) {
    constexpr std::uint64_t changing = O_CREAT | O_TRUNC;
    switch (call) {
#ifdef SYS_open
      case SYS_open:
        return (arguments[1] & changing) != 0;
      case SYS_stat:
      case SYS_lstat:
      case SYS_access:
      case SYS_readlink:
#endif
#ifdef SYS_newfstatat
      case SYS_newfstatat:
#endif
      case SYS_faccessat:
      case SYS_readlinkat:
      case SYS_statx:
      case SYS_fstat:
      case SYS_statfs:
      case SYS_fstatfs:
      case SYS_read:
      case SYS_pread64:
      case SYS_readv:
      case SYS_lseek:
      case SYS_mmap:
      case SYS_getdents64:
      case SYS_fcntl:
      case SYS_ioctl:
      case SYS_flock:
      case SYS_close:
      case SYS_fadvise64:
        return false;
      case SYS_openat:
        return (arguments[2] & changing) != 0;
      default:
        return true;
    }
  }

  static std::vector<TouchedFile> files_of(pid_t thread, long call, const std::uint64_t* arguments) {
    std::vector<TouchedFile> files;
    if (!changes_files(call, arguments)) return files;
    const auto add_named = [&](int argument) {
      const std::string name = text_of_process(thread, arguments[argument]);
      if (!name.empty()) files.push_back({std::filesystem::path(name).filename(), true});
    };
    const auto add_open = [&](int argument) {
      if (arguments[argument] > 1 << 20) return;  // an address, not the number of an open file
      std::error_code none;
      const auto link = "/proc/" + std::to_string(thread) + "/fd/" + std::to_string(arguments[argument]);
      const std::filesystem::path file = std::filesystem::read_symlink(link, none);
      if (!none) files.push_back({file.filename(), false});
    };
    switch (call) {
#ifdef SYS_open
      case SYS_open:
      case SYS_unlink:
      case SYS_mkdir:
      case SYS_rmdir:
      case SYS_chmod:
#endif
      case SYS_truncate:
      case SYS_execve:
        add_named(0);
        break;
#ifdef SYS_rename
      case SYS_rename:
      case SYS_link:
      case SYS_symlink:
        add_named(0);
        add_named(1);
        break;
#endif
      case SYS_openat:
      case SYS_unlinkat:
      case SYS_mkdirat:
      case SYS_fchmodat:
        add_named(1);
        add_open(0);
        break;
#ifdef SYS_renameat
      case SYS_renameat:
#endif
      case SYS_renameat2:
      case SYS_linkat:
        add_named(1);
        add_named(3);
        break;
      case SYS_sendfile:
        add_open(0);
        add_open(1);
        break;
      case SYS_copy_file_range:
        add_open(0);
        add_open(2);
        break;
      default:
        add_open(0);
    }
    return files;
  }
};

}  // namespace tactile::test
