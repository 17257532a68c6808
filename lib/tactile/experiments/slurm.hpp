#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tactile/experiments/processes.hpp"

namespace tactile::experiments {

/// How processes run on a cluster.
struct SlurmOptions {
  std::string partition;                                  ///< empty: the site's default
  std::vector<std::string> sbatch;                        ///< further words for sbatch, which come last: "--time=2:00:00"
  std::function<void(const std::string& sentence)> warn;  ///< may be empty
  std::function<bool()> cancel;  ///< whether to cancel the jobs if the waiting is interrupted or ended. Empty: they are left
  std::chrono::milliseconds poll{3'000};  ///< between two looks at the queue, of one call each
  unsigned attempts = 4;  ///< of a task whose node fails, whose time ends, that is preempted, or that a signal ends
};

/// "slurm" or "slurm:PARTITION". @throws Error  if it is neither
SlurmOptions slurm_named(const std::string& name);

/// The words of `text`, split at blanks that are not in quotes (' or ").
/// @throws Error  if a quote has no end, or a word is no option, or one that `run_on_slurm` sets itself
std::vector<std::string> sbatch_words(const std::string& text);

/// The options of sbatch for each array.
std::vector<std::string> words_of(const SlurmOptions& slurm);

/// Asks Slurm whether it would take a job with these options. Where it may do so later, because its nodes are down or the user
/// has many jobs, `slurm.warn` is called instead; also if `folder` knows jobs of an earlier call: they are collected.
/// @throws Error  if it would not take it, or if its programs are missing
void check_slurm(const SlurmOptions& slurm, const std::filesystem::path& folder);

/// Runs the processes as tasks of job arrays, and waits for them. By `plans[].key` a task that was submitted earlier and
/// does this work is known: it is waited for instead of being submitted again, and if it has ended well meanwhile, it is not run
/// again. Tasks of earlier calls that have the log of one of the plans and another key write the same files: they are cancelled,
/// and when they have ended, `options.prepare` is called.
///
/// Processes that come after each other (`ProcessPlan::after`) are one task, so the later ones also run if the waiting was
/// interrupted.
///
/// `folder` must be shared by all nodes. It gets `jobs.json`, the scripts of the arrays, what Slurm prints, and a file in
/// `ended/` for each process that has ended, with its exit code: these files, and not the queue, show what is done.
///
/// `options.queue` is called after each look with what Slurm says of the tasks: "4 run, 20 wait", or "20 wait (Priority)".
///
/// A task that Slurm ends before its process has ended is submitted again, up to `attempts` times: what runs must be able to
/// resume. Out of memory, cancelled and any other end is an error. If a process fails, the other tasks are cancelled. If Slurm
/// refuses an array, it is submitted in smaller ones, and what is refused while others run, later.
/// @throws Error  as `run_processes`; also if Slurm's commands are missing, refuse the jobs, or do not answer for five minutes
void run_on_slurm(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const std::filesystem::path& folder,
                  const SlurmOptions& slurm);

}  // namespace tactile::experiments
