#include "tactile/experiments/slurm_commands.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <sstream>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/process.hpp"

namespace tactile::experiments {
namespace {

/// A file in memory that a process prints to.
class Printed {
 public:
  Printed() : descriptor_(::memfd_create("printed", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "memfd_create");
  }
  ~Printed() { ::close(descriptor_); }
  Printed(const Printed&) = delete;
  Printed& operator=(const Printed&) = delete;

  int descriptor() const { return descriptor_; }

  std::string text() const {
    std::string text;
    std::array<char, 1 << 16> piece{};
    while (true) {
      const ssize_t size = ::pread(descriptor_, piece.data(), piece.size(), static_cast<off_t>(text.size()));
      if (size <= 0) return text;
      text.append(piece.data(), static_cast<std::size_t>(size));
    }
  }

 private:
  int descriptor_;
};

struct Answer {
  bool succeeded = false;
  std::string printed, complaint;  ///< stdout; stderr in one line
};

std::string in_one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& letter : text) {
    if (letter == '\n') letter = ' ';
  }
  return text;
}

/// @throws Error  if there is no such program
Answer answer_of(const std::string& program, const std::vector<std::string>& arguments) {
  const Printed out, err;
  try {
    // Its own group: Ctrl-C must not end a command of Slurm half-way.
    ChildProcess process(
        {.program = program, .arguments = arguments, .out = out.descriptor(), .err = err.descriptor(), .own_group = true});
    const int status = process.wait();
    return {WIFEXITED(status) && WEXITSTATUS(status) == 0, out.text(), in_one_line(err.text())};
  } catch (const std::system_error&) {
    throw Error(program + ": there is no such program; expected Slurm's commands on this machine, or --executor local");
  }
}

[[noreturn]] void refuse(const Answer& answer) {
  throw JobsRefused(
      fmt::format("sbatch refused the jobs: {}; expected a partition, options and a number of jobs that the cluster takes",
                  answer.complaint));
}

std::string joined(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, ",")); }

}  // namespace

std::optional<std::string> live_job_of(const std::filesystem::path& script) {
  const Answer answer = answer_of("squeue", {"--me", "--noheader", "--format=%F %o"});
  if (!answer.succeeded) throw NoAnswer("squeue does not answer: " + answer.complaint);
  std::istringstream lines(answer.printed);
  std::string job, command;
  while (lines >> job && std::getline(lines >> std::ws, command)) {
    if (command == script.string()) return job;
  }
  return std::nullopt;
}

std::string submit_array(const std::filesystem::path& script, std::size_t tasks, const std::vector<std::string>& words) {
  std::vector<std::string> arguments{"--parsable", fmt::format("--array=0-{}", tasks - 1)};
  arguments.insert(arguments.end(), words.begin(), words.end());
  arguments.push_back(script.string());
  const Answer answer = answer_of("sbatch", arguments);
  if (!answer.succeeded) {
    if (const auto taken = live_job_of(script)) return *taken;  // the answer did not come in time
    refuse(answer);
  }
  std::string job = answer.printed.substr(0, answer.printed.find_first_of(";\n"));
  if (!whole_number_in(job))
    throw Error(fmt::format("sbatch took the jobs and printed '{}'; expected their number (scancel --name=tactile cancels them)",
                            in_one_line(answer.printed)));
  return job;
}

void test_submission(const std::vector<std::string>& words) {
  std::vector<std::string> arguments{"--test-only", "--output=/dev/null", "--wrap=true"};
  arguments.insert(arguments.end(), words.begin(), words.end());
  if (const Answer answer = answer_of("sbatch", arguments); !answer.succeeded) refuse(answer);
}

bool is_alive(const QueuedTask& task) {
  static const std::set<std::string> alive{"PENDING",  "RUNNING",   "SUSPENDED", "COMPLETING", "CONFIGURING",  "REQUEUED",
                                           "RESIZING", "SIGNALING", "STAGE_OUT", "STOPPED",    "REQUEUE_HOLD", "REQUEUE_FED"};
  return alive.contains(task.state);
}

std::map<std::string, QueuedTask> queued_tasks(const std::set<std::string>& tasks) {
  std::map<std::string, QueuedTask> all;
  if (tasks.empty()) return all;
  std::set<std::string> jobs;  // whole ones: a command's arguments have a limit
  for (const std::string& task : tasks) jobs.insert(task.substr(0, task.find('_')));
  const Answer answer =
      answer_of("squeue", {"--noheader", "--array", "--states=all", "--format=%i %T %r", "--jobs=" + joined(jobs)});
  // Slurm forgets jobs some minutes after their end, and then complains of the number.
  if (!answer.succeeded && answer.complaint.find("Invalid job id") == std::string::npos)
    throw Error("squeue does not answer: " + answer.complaint);
  std::istringstream lines(answer.printed);
  std::string task;
  for (QueuedTask queued; lines >> task >> queued.state && std::getline(lines >> std::ws, queued.reason);) all[task] = queued;
  return all;
}

std::map<std::string, std::string> accounted_states(const std::set<std::string>& tasks) {
  std::map<std::string, std::string> states;
  if (tasks.empty()) return states;
  try {
    const Answer answer =
        answer_of("sacct", {"--noheader", "--allocations", "--parsable2", "--format=JobID,State", "--jobs=" + joined(tasks)});
    std::istringstream lines(answer.succeeded ? answer.printed : "");
    for (std::string line; std::getline(lines, line);) {
      const std::size_t bar = line.find('|');
      if (bar == std::string::npos) continue;
      states[line.substr(0, bar)] = line.substr(bar + 1, line.find(' ', bar) - bar - 1);  // "CANCELLED by 1000" is CANCELLED
    }
  } catch (const Error&) {
    // There is no sacct.
  }
  return states;
}

namespace {

/// As many as Slurm still knows.
void cancel_tasks(const std::set<std::string>& tasks) {
  constexpr std::size_t at_once = 500;  // a command's arguments have a limit
  for (auto next = tasks.begin(); next != tasks.end();) {
    std::vector<std::string> arguments{"--quiet"};
    for (; next != tasks.end() && arguments.size() <= at_once; ++next) arguments.push_back(*next);
    try {
      answer_of("scancel", arguments);
    } catch (const Error&) {
      return;
    }
  }
}

}  // namespace

bool end_tasks(const std::set<std::string>& tasks, std::chrono::seconds longest, const std::function<void()>& wait) {
  using Clock = std::chrono::steady_clock;
  if (tasks.empty()) return true;
  for (const auto end = Clock::now() + longest; Clock::now() < end; wait()) {
    try {
      cancel_tasks(tasks);  // each time: it fails where the scheduler is busy
      const std::map<std::string, QueuedTask> queued = queued_tasks(tasks);
      const auto runs = [&](const std::string& task) { return queued.contains(task) && is_alive(queued.at(task)); };
      if (std::none_of(tasks.begin(), tasks.end(), runs)) return true;
    } catch (const Error&) {
      // The scheduler restarts, or is busy.
    }
  }
  return false;
}

std::size_t largest_array() {
  constexpr std::size_t usual = 1001;
  const Answer answer = answer_of("scontrol", {"show", "config"});
  std::istringstream lines(answer.printed);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("MaxArraySize")) continue;
    const std::size_t digits = line.find_first_of("0123456789");
    if (digits == std::string::npos) break;
    const auto size = whole_number_in(line.substr(digits));
    return size && *size > 0 ? static_cast<std::size_t>(*size) : usual;
  }
  return usual;
}

}  // namespace tactile::experiments
