#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tactile {

/// A command to be run as a process of its own.
struct ProcessPlan {
  std::string name;                    ///< for people
  std::vector<std::string> arguments;  ///< behind the program's name
  std::filesystem::path log;           ///< what it says on stderr goes here, replacing what was there; its stdout is not kept
};

struct ProcessesOptions {
  std::filesystem::path program;        ///< this one, as a rule
  unsigned at_once = 1;                 ///< so many run at the same time, > 0
  std::function<void()> while_waiting;  ///< called about ten times a second; what it throws ends the processes. May be empty
  std::function<void(std::size_t index)> begun = {};             ///< told of each as it begins. May be empty
  std::function<void(std::size_t index, double seconds)> ended;  ///< told of each that came to a good end. May be empty
};

/// Runs the processes in their order, several at a time, and waits for them. They end when this process does, however that comes.
/// One that fails ends the others, as Ctrl-C does: they are asked to stop first, and killed after ten seconds.
/// @throws Error  that names the one that failed, and what it said last; whatever `while_waiting` or `ended` throws
void run_processes(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options);

}  // namespace tactile
