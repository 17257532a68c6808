#include "executor_arguments.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <iostream>
#include <string>

#include "interruption.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {
namespace {

/// Asks after Ctrl-C. The end of a budget cancels.
bool asked_to_cancel() {
  if (!interrupted()) return true;
  if (::isatty(STDIN_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0) {
    fmt::print(stderr,
               "\nCancel the jobs on the cluster? Otherwise they continue, and the same command collects them later. [y/N] ");
    std::string answer;
    std::getline(std::cin, answer);
    if (answer == "y" || answer == "Y" || answer == "yes") return true;
  }
  spdlog::warn("the jobs on the cluster continue; the same command collects them later");
  return false;
}

}  // namespace

void add_executor_options(Command& command, ExecutorArguments& args) {
  command
      .add_option("--executor", args.executor,
                  "Where tasks run: local, on this machine; slurm or slurm:PARTITION, as jobs of a Slurm cluster. With slurm, "
                  "data, models and output must be in folders that all nodes share")
      .suggest({"local", "slurm"})
      .check(readable_by([](const std::string& name) {
        if (name != "local") experiments::slurm_named(name);
      }))
      .show_default();
  command.add_option("--sbatch", args.sbatch, "Further options for sbatch, such as \"--time=2:00:00 --account=lab\"")
      .type_name("WORDS");
}

std::optional<experiments::SlurmOptions> slurm_of(const ExecutorArguments& args) {
  if (args.executor == "local") {
    if (args.sbatch.empty()) return std::nullopt;
    throw Error("--sbatch: the executor is local; expected --executor slurm with it");
  }
  experiments::SlurmOptions slurm = experiments::slurm_named(args.executor);
  slurm.sbatch = experiments::sbatch_words(args.sbatch);
  slurm.warn = [](const std::string& sentence) { spdlog::warn("{}", sentence); };
  slurm.cancel = asked_to_cancel;
  return slurm;
}

}  // namespace tactile::cli
