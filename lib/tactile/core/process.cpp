#include "tactile/core/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace tactile {
namespace {

[[noreturn]] void throw_not_started(int error, const std::string& program) {
  throw std::system_error(error, std::generic_category(), program);
}

/// In the child. Between fork and exec, a program with threads may only call async-signal-safe functions.
[[noreturn]] void become(const ProcessOptions& options, char* const* arguments, pid_t parent, int errors) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
  if (options.own_group) ::setpgid(0, 0);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ}) ::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const std::array<int, 3> streams{options.in, options.out, options.err};
  for (int stream = 0; stream < 3; ++stream)
    ::dup2(streams[static_cast<std::size_t>(stream)] >= 0 ? streams[static_cast<std::size_t>(stream)] : nothing, stream);
  ::execvp(options.program.c_str(), arguments);
  const int error = errno;
  static_cast<void>(!::write(errors, &error, sizeof error));
  ::_exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const ProcessOptions& options) {
  std::vector<char*> arguments{const_cast<char*>(options.program.c_str())};
  for (const std::string& argument : options.arguments) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  std::array<int, 2> ends{};  // the child closes its end when it becomes the program, or writes why it could not
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw_not_started(errno, options.program);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ == 0) become(options, arguments.data(), parent, ends[1]);
  int error = pid_ < 0 ? errno : 0;
  ::close(ends[1]);
  ssize_t taken = 0;
  while (pid_ > 0 && (taken = ::read(ends[0], &error, sizeof error)) < 0 && errno == EINTR) {
  }
  ::close(ends[0]);
  if (pid_ > 0 && taken <= 0) return;
  if (pid_ > 0) wait();
  throw_not_started(error, options.program);
}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  send(SIGKILL);
  wait();
}

void ChildProcess::send(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

std::optional<int> ChildProcess::status_if_ended() {
  int status = 0;
  if (pid_ <= 0 || ::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  pid_ = 0;
  return status;
}

int ChildProcess::wait() {
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = 0;
  return status;
}

}  // namespace tactile
