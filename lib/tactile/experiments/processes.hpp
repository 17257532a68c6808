#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tactile::experiments {

/// A command that runs as a process of its own.
struct ProcessPlan {
  std::string name;                       ///< for messages
  std::vector<std::string> arguments;     ///< after the program's name
  std::filesystem::path log;              ///< replaced by what the process writes to stderr; its stdout is not kept
  std::string key = {};                   ///< identifies the work; only `run_on_slurm` uses it
  std::optional<std::size_t> after = {};  ///< index of an earlier plan: this one begins after that one has succeeded
};

struct ProcessesOptions {
  std::filesystem::path program;        ///< usually this one
  unsigned at_once = 1;                 ///< number of processes at the same time, > 0
  std::function<void()> while_waiting;  ///< called about 20 times a second; an exception from it ends the processes. May be empty
  std::function<void(std::size_t index)> begun = {};             ///< called when a process begins. May be empty
  std::function<void(std::size_t index, double seconds)> ended;  ///< called when a process has succeeded. May be empty
  /// Only `run_on_slurm` calls these. They may be empty.
  std::function<void()> prepare = {};  ///< may still set the arguments of plans
  std::function<void(const std::string& text)> queue = {};
};

/// Runs the processes in order, several at a time, and waits for them. While one waits for another, those after it may begin.
/// They end when this process ends, for whatever reason. If one fails, or an exception leaves a callback, the others get SIGINT,
/// and SIGKILL after ten seconds.
/// @throws Error  that names the process that failed and its last message; whatever a callback throws
void run_processes(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options);

/// The last line of a log that is not empty, without the program's name; empty if there is none.
std::string last_message(const std::filesystem::path& log);

}  // namespace tactile::experiments
