#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactile::test {

/// A file that a system call is about to touch.
struct TouchedFile {
  std::string name;      ///< without its folder
  bool by_name = false;  ///< opened, renamed, removed, asked for ...; else through an open file: read, written, synced ...
};

struct TracedEnd {
  bool killed = false;
  std::size_t calls = 0;  ///< that counted, up to its end
  int exit_code = -1;     ///< where it was not killed
};

inline constexpr std::size_t never = std::numeric_limits<std::size_t>::max();

/// The built `tactile` under ptrace: every system call of it, and of all its threads, is stopped before it is done.
class TracedCommand {
 public:
  using Counts = std::function<bool(const TouchedFile&)>;

  /// Runs it in the folder `in`, and kills it instead of letting it do the call with number `kill_at` of those that count, from
  /// 0. Nothing if this machine lets nobody trace. @throws std::runtime_error if tracing fails half-way
  static std::optional<TracedEnd> run(const std::vector<std::string>& arguments, const std::filesystem::path& in,
                                      const Counts& counts, std::size_t kill_at = never) {
    std::vector<char*> words{const_cast<char*>(TACTILE_BINARY)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    const pid_t process = ::fork();
    if (process == 0) {
      const int nowhere = ::open("/dev/null", O_RDWR);
      for (const int stream : {0, 1, 2}) ::dup2(nowhere, stream);
      if (::chdir(in.c_str()) != 0 || ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(126);
      ::raise(SIGSTOP);
      ::execv(TACTILE_BINARY, words.data());
      ::_exit(127);
    }
    int status = 0;
    if (::waitpid(process, &status, 0) != process || !WIFSTOPPED(status)) return std::nullopt;
    constexpr long options = PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK |
                             PTRACE_O_TRACEVFORK | PTRACE_O_TRACEEXEC;
    if (::ptrace(PTRACE_SETOPTIONS, process, nullptr, options) != 0) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
      return std::nullopt;
    }
    return TracedCommand(process, counts, kill_at).follow();
  }

 private:
  TracedCommand(pid_t process, const Counts& counts, std::size_t kill_at)
      : process_(process), counts_(counts), kill_at_(kill_at) {}

  TracedEnd follow() {
    TracedEnd end;
    ::ptrace(PTRACE_SYSCALL, process_, nullptr, 0);
    for (;;) {
      int status = 0;
      const pid_t stopped = ::waitpid(-1, &status, __WALL);
      if (stopped < 0) throw std::runtime_error("the traced command is gone");
      if (WIFEXITED(status) || WIFSIGNALED(status)) {
        if (stopped != process_) continue;
        end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        return end;
      }
      int passed_on = WSTOPSIG(status);
      if (passed_on == (SIGTRAP | 0x80)) {
        passed_on = 0;
        if (!end.killed && touches(stopped)) {
          if (end.calls == kill_at_) {
            end.killed = true;
            ::kill(process_, SIGKILL);
            continue;
          }
          ++end.calls;
        }
      } else if (passed_on == SIGTRAP || passed_on == SIGSTOP) {
        passed_on = 0;  // a new thread, or another program in the same process
      }
      ::ptrace(PTRACE_SYSCALL, stopped, nullptr, passed_on);
    }
  }

  /// Whether the thread stands before a call that counts.
  bool touches(pid_t thread) const {
    __ptrace_syscall_info info{};
    if (::ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info) <= 0 || info.op != PTRACE_SYSCALL_INFO_ENTRY) return false;
    const std::vector<TouchedFile> files = files_of(thread, static_cast<long>(info.entry.nr), info.entry.args);
    return std::any_of(files.begin(), files.end(), counts_);
  }

  static std::vector<TouchedFile> files_of(pid_t thread, long call, const __uint64_t* arguments) {
    std::vector<TouchedFile> files;
    const auto add_named = [&](int argument) {
      const std::string name = text_at(thread, arguments[argument]);
      if (!name.empty()) files.push_back({std::filesystem::path(name).filename(), true});
    };
    const auto add_open = [&](int argument) {
      if (arguments[argument] > 1 << 20) return;  // no open file, but a place in memory
      std::error_code none;
      const auto link = "/proc/" + std::to_string(thread) + "/fd/" + std::to_string(arguments[argument]);
      const std::filesystem::path file = std::filesystem::read_symlink(link, none);
      if (!none) files.push_back({file.filename(), false});
    };
    switch (call) {
#ifdef SYS_open
      case SYS_open:
      case SYS_stat:
      case SYS_lstat:
      case SYS_access:
      case SYS_unlink:
      case SYS_mkdir:
      case SYS_rmdir:
      case SYS_chmod:
      case SYS_readlink:
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
      case SYS_faccessat:
      case SYS_fchmodat:
      case SYS_readlinkat:
      case SYS_statx:
#ifdef SYS_newfstatat
      case SYS_newfstatat:
#endif
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
      case SYS_mmap:
        add_open(4);
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

  static std::string text_at(pid_t thread, __uint64_t address) {
    std::array<char, 4096> bytes{};
    const int memory = ::open(("/proc/" + std::to_string(thread) + "/mem").c_str(), O_RDONLY | O_CLOEXEC);
    if (memory < 0) return {};
    const ssize_t got = ::pread(memory, bytes.data(), bytes.size() - 1, static_cast<off_t>(address));
    ::close(memory);
    return got > 0 ? std::string(bytes.data()) : std::string();
  }

  pid_t process_;
  const Counts& counts_;
  std::size_t kill_at_;
};

}  // namespace tactile::test
