#pragma once

#include <optional>
#include <string>

#include "command.hpp"
#include "tactile/experiments/slurm.hpp"

namespace tactile::cli {

/// Where the trainings and judgements of an experiment run.
struct ExecutorArguments {
  std::string executor = "local";
  std::string sbatch;
};

void add_executor_options(Command& command, ExecutorArguments& args);

/// Nothing: on this machine. After Ctrl-C a person at a terminal is asked whether to cancel the jobs.
/// @throws Error  if words for sbatch are given without a cluster
std::optional<experiments::SlurmOptions> slurm_of(const ExecutorArguments& args);

}  // namespace tactile::cli
