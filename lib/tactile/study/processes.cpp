#include "tactile/study/processes.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string_view>
#include <thread>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int could_not_start = 127;

/// A child and when it began.
struct Child {
  pid_t pid = 0;
  std::size_t index = 0;
  Clock::time_point begun{};
};

/// The last line that is not empty, without the program's name in front.
std::string last_words(const fs::path& log) {
  std::ifstream file(log);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view name = "tactile: ";
  return last.starts_with(name) ? last.substr(name.size()) : last;
}

/// Children that run, and end with this.
class Children {
 public:
  explicit Children(const std::vector<ProcessPlan>& plans) : plans_(plans) {}
  ~Children() { stop(); }
  Children(const Children&) = delete;
  Children& operator=(const Children&) = delete;

  std::size_t running() const { return children_.size(); }

  void start(std::size_t index, const fs::path& program) {
    const ProcessPlan& plan = plans_[index];
    fs::create_directories(plan.log.parent_path());
    const int log = ::open(plan.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (log < 0 || nothing < 0) {
      if (log >= 0) ::close(log);
      if (nothing >= 0) ::close(nothing);
      throw Error(plan.log.string() + ": cannot be written; expected a writable place with room");
    }
    std::vector<std::string> words{program.string()};
    words.insert(words.end(), plan.arguments.begin(), plan.arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const pid_t parent = ::getpid();
    const pid_t pid = ::fork();
    if (pid == 0) {
      // Between fork and exec of a program with threads only what is safe in a signal's handler.
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (::getppid() != parent) ::_exit(could_not_start);
      ::signal(SIGINT, SIG_DFL);  // a shell's background jobs ignore it, and it is how we ask a process to stop
      ::dup2(nothing, STDIN_FILENO);
      ::dup2(nothing, STDOUT_FILENO);
      ::dup2(log, STDERR_FILENO);
      ::execv(argv.front(), argv.data());
      ::_exit(could_not_start);
    }
    const int why = errno;
    ::close(log);
    ::close(nothing);
    if (pid < 0) throw Error(fmt::format("{}: no process could be started ({})", plan.name, std::strerror(why)));
    children_.push_back({pid, index, Clock::now()});
  }

  /// Those that have ended since, with how: as waitpid tells it.
  std::vector<std::pair<Child, int>> reap() {
    std::vector<std::pair<Child, int>> ended;
    for (auto child = children_.begin(); child != children_.end();) {
      int status = 0;
      if (::waitpid(child->pid, &status, WNOHANG) == child->pid) {
        ended.emplace_back(*child, status);
        child = children_.erase(child);
      } else {
        ++child;
      }
    }
    return ended;
  }

  void stop() noexcept {
    for (const Child& child : children_) ::kill(child.pid, SIGINT);
    const auto patience = Clock::now() + std::chrono::seconds(10);
    while (!children_.empty() && Clock::now() < patience) {
      reap();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    for (const Child& child : children_) {
      ::kill(child.pid, SIGKILL);
      ::waitpid(child.pid, nullptr, 0);
    }
    children_.clear();
  }

 private:
  const std::vector<ProcessPlan>& plans_;
  std::vector<Child> children_;
};

std::string why_it_failed(const ProcessPlan& plan, int status) {
  if (WIFSIGNALED(status)) return fmt::format("it was killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  const std::string words = last_words(plan.log);
  if (!words.empty()) return words;
  return fmt::format("it ended with {} and said nothing", WEXITSTATUS(status));
}

}  // namespace

void run_processes(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options) {
  Children children(plans);
  std::size_t next = 0;
  while (next < plans.size() || children.running() > 0) {
    while (next < plans.size() && children.running() < std::max(1U, options.at_once)) {
      children.start(next, options.program);
      if (options.begun) options.begun(next);
      ++next;
    }
    if (options.while_waiting) options.while_waiting();
    const auto ended = children.reap();
    for (const auto& [child, status] : ended) {
      if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        if (options.ended) options.ended(child.index, std::chrono::duration<double>(Clock::now() - child.begun).count());
        continue;
      }
      if (options.while_waiting) options.while_waiting();  // Ctrl-C reaches them all at once, and is nobody's failure
      const ProcessPlan& plan = plans[child.index];
      throw Error(fmt::format("'{}' failed: {}", plan.name, why_it_failed(plan, status)));
    }
    if (ended.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace tactile
