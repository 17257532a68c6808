#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
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

/// Submits an array of `tasks` tasks. @return  the job's number. @throws JobsRefused  with what sbatch prints
std::string submit_array(const std::filesystem::path& script, std::size_t tasks, const std::vector<std::string>& words);

/// Submits nothing. @throws JobsRefused  if sbatch would not take a job with these options
void test_submission(const std::vector<std::string>& words);

/// The states of the tasks of these jobs that Slurm still knows, by "12_3": "PENDING", "RUNNING", "NODE_FAIL", …
/// @throws Error  if squeue does not answer
std::map<std::string, std::string> task_states(const std::set<std::string>& jobs);

/// The last states of tasks by the site's accounting, by "12_3"; of those alone that it knows.
std::map<std::string, std::string> accounted_states(const std::set<std::string>& tasks);

void cancel_tasks(const std::set<std::string>& tasks);  ///< as many as Slurm still knows; never throws

/// The most tasks of one array here.
std::size_t largest_array();

}  // namespace tactile::experiments
