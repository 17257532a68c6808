#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactile {

/// A program to run as a child process.
struct ProcessOptions {
  std::string program;                 ///< a path, or a name that is looked up in PATH
  std::vector<std::string> arguments;  ///< after the program's name
  int in = -1, out = -1, err = -1;     ///< file descriptors of its standard streams; -1: /dev/null
  bool own_group = false;              ///< Ctrl-C in a terminal does not reach it
};

/// A running child process. SIGINT, SIGTERM, SIGPIPE and SIGXFSZ have their default effect on it, and no signal is blocked. It
/// gets SIGKILL when this object is destroyed, or the thread that started it ends.
class ChildProcess {
 public:
  /// @throws std::system_error  if it cannot be started: ENOENT if there is no such program
  explicit ChildProcess(const ProcessOptions& options);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
  ChildProcess& operator=(ChildProcess&& other) noexcept {
    std::swap(pid_, other.pid_);
    return *this;
  }

  void send(int signal) const;  ///< without effect once it has ended

  /// The status that `waitpid` gives once it has ended; nothing while it runs, and after its status was returned.
  std::optional<int> status_if_ended();

  /// Waits for its end. @return  the status that `waitpid` gives
  int wait();

 private:
  pid_t pid_ = 0;  ///< 0 once its status was returned
};

}  // namespace tactile
