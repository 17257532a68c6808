#include "tactile/experiments/slurm_script.hpp"

#include <fmt/format.h>

#include <fstream>

#include "tactile/core/text_lines.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;

std::string command_of(const ScriptedProcess& process, const fs::path& program) {
  std::string command = fmt::format("run {} {} {} {}", shell_word(process.mark), shell_word(process.plan->key),
                                    shell_word(fs::absolute(process.plan->log).string()), shell_word(program.string()));
  for (const std::string& word : process.plan->arguments) command += " " + shell_word(word);
  return command;
}

}  // namespace

std::optional<Mark> read_mark(const fs::path& file) {
  std::ifstream line(file);
  Mark mark;
  double milliseconds = 0;
  if (!(line >> mark.key >> mark.task >> mark.code >> milliseconds)) return std::nullopt;
  line >> mark.node;
  mark.seconds = milliseconds / 1e3;
  return mark;
}

std::string script_of(const std::vector<ScriptedTask>& tasks, const fs::path& program, const fs::path& marks) {
  std::string script = fmt::format(
      "#!/bin/sh\n"
      "# The tasks of a job array.\n"
      "cd {} || exit 1\n"
      "trap : TERM  # ends after its process, which still writes files\n"
      "run() {{  # NAME KEY LOG PROGRAM WORD...\n"
      "  name=$1 key=$2 log=$3\n"
      "  shift 3\n"
      "  mark={}/$name task=${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\n"
      "  grep -qs \"^$key $task 0 \" \"$mark\" && return 0\n"
      "  begun=$(date +%s%N)\n"
      "  \"$@\" </dev/null >/dev/null 2>\"$log\"\n"
      "  code=$?\n"
      "  took=$((($(date +%s%N) - begun) / 1000000))\n"
      "  echo \"$key $task $code $took $SLURMD_NODENAME\" >\"$mark.part$$\" && mv \"$mark.part$$\" \"$mark\"\n"
      "  return $code\n"
      "}}\n"
      "case $SLURM_ARRAY_TASK_ID in\n",
      shell_word(fs::current_path().string()), shell_word(marks.string()));
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    script += fmt::format("{}) {}", i, command_of(tasks[i].front(), program));
    for (std::size_t next = 1; next < tasks[i].size(); ++next) script += " && " + command_of(tasks[i][next], program);
    script += " ;;\n";
  }
  return script + "esac\n";
}

}  // namespace tactile::experiments
