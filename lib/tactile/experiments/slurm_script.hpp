#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/experiments/processes.hpp"

namespace tactile::experiments {

/// What a process of a task leaves when it has ended: a line in a file.
struct Mark {
  std::string key;   ///< `ProcessPlan::key`
  std::string task;  ///< of Slurm, in which it ran: "12_3"
  int code = 0;      ///< 128 and more: the number of the signal that ended it, plus 128, as shells have it
  double seconds = 0;
  std::string node;  ///< name of the machine

  bool is_of_signal() const { return code >= 128; }
};

/// Nothing if the file is missing or damaged.
std::optional<Mark> read_mark(const std::filesystem::path& file);

/// A process of a task.
struct ScriptedProcess {
  std::string mark;  ///< name of its mark
  const ProcessPlan* plan;
};

/// Processes that run one after the other, each if the one before has succeeded.
using ScriptedTask = std::vector<ScriptedProcess>;

/// The script of a job array: its task i runs `tasks[i]`. A mark appears in one step. Where Slurm starts a task again, processes
/// that have succeeded do not run again.
/// @param program  runs with the arguments of each plan
/// @param marks    folder of the marks
std::string script_of(const std::vector<ScriptedTask>& tasks, const std::filesystem::path& program,
                      const std::filesystem::path& marks);

}  // namespace tactile::experiments
