#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactile::test {

/// A system call of a traced thread.
struct TracedCall {
  pid_t thread = 0;
  long number = 0;
  std::array<std::uint64_t, 6> arguments{};
  std::int64_t result = 0;  ///< valid after the end of the call
};

/// The text at an address in the memory of a traced thread; empty if it cannot be read.
inline std::string text_of_process(pid_t thread, std::uint64_t address) {
  std::array<char, 4096> bytes{};
  const int memory = ::open(("/proc/" + std::to_string(thread) + "/mem").c_str(), O_RDONLY | O_CLOEXEC);
  if (memory < 0) return {};
  const ssize_t got = ::pread(memory, bytes.data(), bytes.size() - 1, static_cast<off_t>(address));
  ::close(memory);
  return got > 0 ? std::string(bytes.data()) : std::string();
}

/// Runs a program in the folder `in` under ptrace. Calls `begins` before each system call of the program, of all its threads and
/// of the processes that it starts, and `ends` after it. If `begins` returns false, the program is killed before the call. Longer
/// than other functions: it is the loop that ptrace requires, with a case for each stop of a thread.
/// @return its exit code, -1 if it was killed; nothing if this machine allows no tracing
/// @throws std::runtime_error if tracing fails later
template <class Begins, class Ends>
std::optional<int> trace_calls(const std::vector<std::string>& words, const std::filesystem::path& in, const Begins& begins,
                               const Ends& ends) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t process = ::fork();
  if (process == 0) {
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) ::dup2(nowhere, stream);
    const char* sanitizer = std::getenv("ASAN_OPTIONS");
    ::setenv("ASAN_OPTIONS", ((sanitizer == nullptr ? "" : std::string(sanitizer) + ":") + "detect_leaks=0").c_str(),
             1);  // the detection of leaks uses ptrace, too
    if (::chdir(in.c_str()) != 0 || ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(126);
    ::raise(SIGSTOP);
    ::execvp(arguments[0], arguments.data());
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
  ::ptrace(PTRACE_SYSCALL, process, nullptr, 0);
  std::map<pid_t, TracedCall> calls;
  bool killed = false;
  for (;;) {
    const pid_t stopped = ::waitpid(-1, &status, __WALL);
    if (stopped < 0) throw std::runtime_error("the traced command has no process left");
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (stopped == process) return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      continue;
    }
    int passed_on = WSTOPSIG(status);
    if (passed_on == (SIGTRAP | 0x80)) {
      passed_on = 0;
      __ptrace_syscall_info info{};
      if (!killed && ::ptrace(PTRACE_GET_SYSCALL_INFO, stopped, sizeof info, &info) > 0) {
        TracedCall& call = calls[stopped];
        if (info.op == PTRACE_SYSCALL_INFO_ENTRY) {
          call = {.thread = stopped, .number = static_cast<long>(info.entry.nr), .arguments = {}, .result = 0};
          for (std::size_t i = 0; i < call.arguments.size(); ++i) call.arguments[i] = info.entry.args[i];
          if (!begins(call)) {
            killed = true;
            ::kill(process, SIGKILL);
            continue;
          }
        } else if (info.op == PTRACE_SYSCALL_INFO_EXIT) {
          call.result = info.exit.rval;
          ends(call);
        }
      }
    } else if (passed_on == SIGTRAP || passed_on == SIGSTOP) {
      passed_on = 0;  // stops of ptrace itself: a new thread, or exec
    }
    ::ptrace(PTRACE_SYSCALL, stopped, nullptr, passed_on);
  }
}

}  // namespace tactile::test
