#include "tactile/experiments/processes.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <numeric>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/process.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Child {
  ChildProcess process;
  std::size_t index = 0;
  Clock::time_point begun{};
};

ChildProcess start(const ProcessPlan& plan, const fs::path& program) {
  fs::create_directories(plan.log.parent_path());
  const int log = ::open(plan.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log < 0) throw Error(plan.log.string() + ": cannot be written; expected a writable place with room");
  try {
    ChildProcess process({.program = program.string(), .arguments = plan.arguments, .err = log});
    ::close(log);
    return process;
  } catch (const std::system_error& e) {
    ::close(log);
    throw Error(fmt::format("{}: no process could be started ({})", plan.name, e.code().message()));
  }
}

/// Asks all to stop, and gives them ten seconds. Those that still run then are killed with their objects.
void stop(std::vector<Child>& children) {
  for (const Child& child : children) child.process.send(SIGINT);
  const auto end = Clock::now() + std::chrono::seconds(10);
  while (!children.empty() && Clock::now() < end) {
    if (std::erase_if(children, [](Child& child) { return child.process.status_if_ended().has_value(); }) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

std::string why_it_failed(const ProcessPlan& plan, int status) {
  if (WIFSIGNALED(status)) return fmt::format("it was killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  std::string words = last_message(plan.log);
  if (!words.empty()) return words;
  return fmt::format("it ended with {} and no message", WEXITSTATUS(status));
}

void run_all(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, std::vector<Child>& children) {
  std::deque<std::size_t> waiting(plans.size());
  std::iota(waiting.begin(), waiting.end(), std::size_t{0});
  std::vector<bool> succeeded(plans.size());
  const auto may_begin = [&](std::size_t index) { return !plans[index].after || succeeded[*plans[index].after]; };
  while (!waiting.empty() || !children.empty()) {
    while (children.size() < std::max(1U, options.at_once)) {
      const auto next = std::find_if(waiting.begin(), waiting.end(), may_begin);
      if (next == waiting.end()) break;
      const std::size_t index = *next;
      waiting.erase(next);
      children.push_back({start(plans[index], options.program), index, Clock::now()});
      if (options.begun) options.begun(index);
    }
    if (options.while_waiting) options.while_waiting();
    const std::size_t running = children.size();
    std::string failure;  // the first one, once all that have ended well are reported
    for (std::size_t i = 0; i < children.size();) {
      const std::optional<int> status = children[i].process.status_if_ended();
      if (!status) {
        ++i;
        continue;
      }
      const Child child = std::move(children[i]);
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      if (WIFEXITED(*status) && WEXITSTATUS(*status) == 0) {
        succeeded[child.index] = true;
        if (options.ended) options.ended(child.index, std::chrono::duration<double>(Clock::now() - child.begun).count());
        continue;
      }
      const ProcessPlan& plan = plans[child.index];
      if (failure.empty()) failure = fmt::format("'{}' failed: {}", plan.name, why_it_failed(plan, *status));
    }
    if (!failure.empty()) {
      // Throws after Ctrl-C, which reaches the children too: that is no failure.
      if (options.while_waiting) options.while_waiting();
      throw Error(failure);
    }
    if (children.size() == running) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace

std::string last_message(const fs::path& log) {
  std::ifstream file(log);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view name = "tactile: ";
  return last.starts_with(name) ? last.substr(name.size()) : last;
}

void run_processes(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options) {
  std::vector<Child> children;
  try {
    run_all(plans, options, children);
  } catch (...) {
    stop(children);
    throw;
  }
}

}  // namespace tactile::experiments
