#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::experiments {

/// sbatch did not take the jobs: there are too many, or it does not know an option.
class JobsRefused : public Error {
 public:
  using Error::Error;
};

/// Slurm's programs do not answer. Its jobs are left.
class NoAnswer : public Error {
 public:
  using Error::Error;
};

/// The job of this script that waits or runs; nothing if there is none. @throws NoAnswer
std::optional<std::string> live_job_of(const std::filesystem::path& script);

/// Submits an array of `tasks` tasks. @return  the job's number.
/// @throws JobsRefused  with what sbatch prints
/// @throws Error        if sbatch succeeds and prints no number
std::string submit_array(const std::filesystem::path& script, std::size_t tasks, const std::vector<std::string>& words);

/// Submits nothing. @throws JobsRefused  if sbatch would not take a job with these options now
void test_submission(const std::vector<std::string>& words);

/// What the queue says of a task.
struct QueuedTask {
  std::string state;   ///< "PENDING", "RUNNING", "NODE_FAIL", …
  std::string reason;  ///< why it waits: "Priority", "Resources", …
};

/// Whether what Slurm does with the task is not over.
bool is_alive(const QueuedTask& task);

/// What the queue says of these tasks ("12_3") that Slurm still knows, and of others of the same jobs.
/// @throws Error  if squeue does not answer
std::map<std::string, QueuedTask> queued_tasks(const std::set<std::string>& tasks);

/// The last states of tasks by the site's accounting, by "12_3"; of those alone that it knows.
std::map<std::string, std::string> accounted_states(const std::set<std::string>& tasks);

/// Cancels tasks, and waits until they have ended: until then they write their files.
/// @param wait  called between two looks at the queue
/// @return      whether they ended within the time `longest`
bool end_tasks(const std::set<std::string>& tasks, std::chrono::seconds longest, const std::function<void()>& wait);

/// The most tasks of one array here.
std::size_t largest_array();

}  // namespace tactile::experiments
