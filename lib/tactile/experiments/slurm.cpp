#include "tactile/experiments/slurm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/slurm_commands.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int form_of_jobs = 2;  ///< of the entries in jobs.json and of marks. With another number they are other work

/// Slurm's programs have not answered for long. Its jobs are left.
class NoAnswer : public Error {
 public:
  using Error::Error;
};

/// What a process leaves when it has ended.
struct Mark {
  std::string key;
  std::string task;  ///< of Slurm, in which it ran
  int code = 0;      ///< 128 and more: the number of the signal that ended it, plus 128, as shells have it
  double seconds = 0;

  bool is_of_signal() const { return code >= 128; }
};

/// A process in a task of a job.
struct Task {
  std::size_t index = 0;   ///< in the plans
  std::string name;        ///< of its files
  std::string id;          ///< "12_3"; the same for processes that come after each other
  Task* before = nullptr;  ///< must succeed first
  bool due = false;        ///< to be submitted
  unsigned attempts = 0;
  unsigned looks_without_it = 0;  ///< at which Slurm did not run it, and there was no mark
  bool begun = false, ended = false;

  bool waits() const { return before && !before->ended; }
};

/// Tasks whose processes run one after the other, in one task of Slurm.
using Chain = std::vector<Task*>;

/// The tasks of one call, and their files in `folder`.
class Jobs {
 public:
  Jobs(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const fs::path& folder, const SlurmOptions& slurm)
      : plans_(plans), options_(options), folder_(fs::absolute(folder)), slurm_(slurm) {
    fs::create_directories(folder_ / "ended");
    for (std::size_t i = 0; i < plans.size(); ++i) tasks_.push_back({.index = i, .name = plans[i].log.stem().string(), .id = {}});
    for (Task& task : tasks_) {
      if (const auto after = plans[task.index].after) task.before = &tasks_[*after];
    }
  }

  void run();
  void cancel();
  bool all_ended() const {
    return std::all_of(tasks_.begin(), tasks_.end(), [](const Task& task) { return task.ended; });
  }

 private:
  fs::path mark_of(const Task& task) const { return folder_ / "ended" / task.name; }
  std::optional<Mark> read_mark(const Task& task) const;
  void find_earlier_tasks();
  void remember();
  std::vector<Chain> due_chains();
  void submit_due();
  void submit(const std::vector<Chain>& chains);
  std::string command_of(const Task& task) const;
  std::string script_of(const std::vector<Chain>& chains) const;
  void look();
  bool look_for_mark(Task& task);
  void find_due(const std::map<std::string, std::string>& states);
  void check_may_repeat(const Task& task, const std::string& state) const;

  const std::vector<ProcessPlan>& plans_;
  const ProcessesOptions& options_;
  fs::path folder_;
  const SlurmOptions& slurm_;
  std::vector<Task> tasks_;
  nlohmann::json jobs_ = nlohmann::json::object();        ///< jobs.json, which also has tasks of other calls
  std::vector<std::pair<std::string, fs::path>> passed_;  ///< the task and mark of processes that have succeeded
  Clock::time_point last_answer_ = Clock::now();
  std::optional<Clock::time_point> last_ran_;  ///< when a task of this call was last in the queue
  Clock::time_point next_submission_{};        ///< after Slurm has refused one
};

std::optional<Mark> Jobs::read_mark(const Task& task) const {
  std::ifstream file(mark_of(task));
  Mark mark;
  double milliseconds = 0;
  if (!(file >> mark.key >> mark.task >> mark.code >> milliseconds)) return std::nullopt;
  if (mark.key != plans_[task.index].key || mark.task != task.id) return std::nullopt;
  mark.seconds = milliseconds / 1e3;
  return mark;
}

/// Takes over tasks of this work that were submitted before, and cancels those of the same names with other work: they would
/// write the same files. Files that cannot be read mean that there are none.
void Jobs::find_earlier_tasks() {
  try {
    if (nlohmann::json read = read_json(folder_ / "jobs.json"); read.is_object()) jobs_ = std::move(read);
  } catch (const Error&) {
    return;
  }
  std::set<std::string> others;
  for (Task& task : tasks_) {
    const auto found = jobs_.find(task.name);
    if (found == jobs_.end() || !found->is_object()) continue;
    const bool is_this_work = found->value("form", 0) == form_of_jobs && found->value("key", "") == plans_[task.index].key;
    if (is_this_work) {
      task.id = found->value("task", "");
    } else if (const std::string id = found->value("task", ""); !id.empty()) {
      others.insert(id);
    }
  }
  for (Task& task : tasks_) {
    if (others.contains(task.id)) task.id.clear();  // this task also does other work
  }
  cancel_tasks(others);
}

/// Entries of other calls stay.
void Jobs::remember() {
  for (const Task& task : tasks_) {
    if (task.id.empty()) {
      jobs_.erase(task.name);
    } else {
      jobs_[task.name] = {{"form", form_of_jobs}, {"key", plans_[task.index].key}, {"task", task.id}};
    }
  }
  write_json(folder_ / "jobs.json", jobs_);
}

std::string Jobs::command_of(const Task& task) const {
  const ProcessPlan& plan = plans_[task.index];
  std::string command = fmt::format("run {} {} {} {}", shell_word(task.name), shell_word(plan.key),
                                    shell_word(fs::absolute(plan.log).string()), shell_word(options_.program.string()));
  for (const std::string& word : plan.arguments) command += " " + shell_word(word);
  return command;
}

/// One branch for each chain. A mark appears in one step. Where Slurm starts a task again, processes that have succeeded do not
/// run again.
std::string Jobs::script_of(const std::vector<Chain>& chains) const {
  std::string script = fmt::format(
      "#!/bin/sh\n"
      "# The tasks of a job array.\n"
      "cd {} || exit 1\n"
      "run() {{  # NAME KEY LOG PROGRAM WORD...\n"
      "  name=$1 key=$2 log=$3\n"
      "  shift 3\n"
      "  mark={}/$name task=${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\n"
      "  grep -qs \"^$key $task 0 \" \"$mark\" && return 0\n"
      "  begun=$(date +%s%N)\n"
      "  \"$@\" </dev/null >/dev/null 2>\"$log\"\n"
      "  code=$?\n"
      "  echo \"$key $task $code $((($(date +%s%N) - begun) / 1000000))\" >\"$mark.part$$\" && mv \"$mark.part$$\" \"$mark\"\n"
      "  return $code\n"
      "}}\n"
      "case $SLURM_ARRAY_TASK_ID in\n",
      shell_word(fs::current_path().string()), shell_word((folder_ / "ended").string()));
  for (std::size_t i = 0; i < chains.size(); ++i) {
    script += fmt::format("{}) {}", i, command_of(*chains[i].front()));
    for (std::size_t next = 1; next < chains[i].size(); ++next) script += " && " + command_of(*chains[i][next]);
    script += " ;;\n";
  }
  return script + "esac\n";
}

void Jobs::submit(const std::vector<Chain>& chains) {
  for (const Chain& chain : chains) {
    for (const Task* task : chain) {
      fs::remove(mark_of(*task));
      fs::create_directories(plans_[task->index].log.parent_path());
    }
  }
  const std::string text = script_of(chains);
  const fs::path script = folder_ / (sha256_of(text).substr(0, 12) + ".sh");
  write_whole(script, text);
  std::vector<std::string> words = words_of(slurm_);
  words.push_back("--output=" + (folder_ / "slurm.log").string());
  const std::string job = submit_array(script, chains.size(), words);
  for (std::size_t i = 0; i < chains.size(); ++i) {
    for (Task* task : chains[i]) {
      task->id = fmt::format("{}_{}", job, i);
      task->due = false;
      task->looks_without_it = 0;
      task->attempts = task->waits() ? 1 : task->attempts + 1;
    }
  }
  remember();
}

std::vector<Chain> Jobs::due_chains() {
  std::vector<Chain> chains;
  std::map<const Task*, std::size_t> chain_of;
  for (Task& task : tasks_) {
    if (!task.due) continue;
    const auto earlier = chain_of.find(task.before);
    if (earlier == chain_of.end()) chains.emplace_back();
    const std::size_t chain = earlier == chain_of.end() ? chains.size() - 1 : earlier->second;
    chains[chain].push_back(&task);
    chain_of[&task] = chain;
  }
  return chains;
}

/// Submits what is due. If Slurm takes no more, the rest stays due as long as other tasks run.
void Jobs::submit_due() {
  constexpr auto patience = std::chrono::minutes(1);  // with tasks that have ended, and that Slurm still counts
  const std::vector<Chain> chains = due_chains();
  if (chains.empty() || Clock::now() < next_submission_) return;
  std::size_t most = largest_array();
  for (std::size_t first = 0; first < chains.size();) {
    const std::size_t count = std::min(most, chains.size() - first);
    const auto begin = chains.begin() + static_cast<std::ptrdiff_t>(first);
    try {
      submit({begin, begin + static_cast<std::ptrdiff_t>(count)});
      first += count;
      last_ran_ = Clock::now();
    } catch (const JobsRefused& refused) {
      std::ofstream(folder_ / "slurm.log", std::ios::app) << refused.what() << '\n';
      most = count / 2;
      if (most > 0) continue;
      if (!last_ran_ || Clock::now() - *last_ran_ > patience) throw;
      next_submission_ = Clock::now() + 20 * slurm_.poll;
      return;
    }
  }
}

/// Whether the task has ended. @throws Error  if its process failed
bool Jobs::look_for_mark(Task& task) {
  if (task.waits() || task.id.empty()) return false;
  const std::optional<Mark> mark = read_mark(task);
  if (!mark || mark->is_of_signal()) return false;  // Slurm's state says why, and whether to repeat it
  const ProcessPlan& plan = plans_[task.index];
  if (mark->code != 0) {
    const std::string words = last_message(plan.log);
    throw Error(fmt::format("'{}' failed: {}", plan.name,
                            words.empty() ? fmt::format("it ended with {} and no message", mark->code) : words));
  }
  if (!task.begun && options_.begun) options_.begun(task.index);
  if (options_.ended) options_.ended(task.index, mark->seconds);
  task.begun = task.ended = true;
  passed_.emplace_back(std::exchange(task.id, {}), mark_of(task));
  return true;
}

void Jobs::check_may_repeat(const Task& task, const std::string& state) const {
  static const std::set<std::string> may_repeat{"NODE_FAIL", "BOOT_FAIL", "PREEMPTED", "TIMEOUT", "REVOKED", ""};
  const std::string& name = plans_[task.index].name;
  if (state == "OUT_OF_MEMORY")
    throw Error(
        fmt::format("'{}' failed: job {} needed more memory than it was given; expected --sbatch with more, such as "
                    "\"--mem=4G\"",
                    name, task.id));  // clang-format off
  if (state == "CANCELLED") throw Error(fmt::format("'{}' failed: job {} was cancelled", name, task.id));
  if (const std::optional<Mark> mark = read_mark(task); state == "FAILED" && mark && mark->is_of_signal()) {
    if (task.attempts < slurm_.attempts) return;
    throw Error(fmt::format("'{}' failed: it was started {} times, and signal {} ended it the last time; if memory was short, "
                            "expected --sbatch with more, such as \"--mem=4G\" (its log: {})",
                            name, task.attempts, mark->code - 128, plans_[task.index].log.string()));
  }
  if (!may_repeat.contains(state))
    throw Error(fmt::format("'{}' failed: Slurm ended job {} as {}, and there is no {}; expected a folder that all nodes share "
                            "(what Slurm printed: {})", name, task.id, state, mark_of(task).string(), (folder_ / "slurm.log").string()));
  if (task.attempts >= slurm_.attempts)
    throw Error(fmt::format("'{}' failed: Slurm ended it {} times, the last time as {}; expected more time or other nodes, by "
                            "--sbatch", name, task.attempts, state.empty() ? "forgotten" : state));
  // clang-format on
}

/// Tasks that Slurm no longer runs, and whose process has not ended by itself, are due again: a mark may reach this machine some
/// seconds late. What comes after a task that is due is due with it.
void Jobs::find_due(const std::map<std::string, std::string>& states) {
  static const std::set<std::string> alive{"PENDING",  "RUNNING",   "SUSPENDED", "COMPLETING", "CONFIGURING",  "REQUEUED",
                                           "RESIZING", "SIGNALING", "STAGE_OUT", "STOPPED",    "REQUEUE_HOLD", "REQUEUE_FED"};
  constexpr unsigned patience = 4;
  std::vector<Task*> lost;
  std::set<std::string> forgotten;  // of the lost ones, by squeue
  for (Task& task : tasks_) {
    if (task.ended || task.waits()) continue;
    if (task.id.empty()) {
      task.due = true;
      continue;
    }
    const auto found = states.find(task.id);
    if (found != states.end() && alive.contains(found->second)) {
      task.looks_without_it = 0;
      last_ran_ = Clock::now();
      if (found->second == "RUNNING" && !task.begun) {
        task.begun = true;
        if (options_.begun) options_.begun(task.index);
      }
      continue;
    }
    if (++task.looks_without_it < patience) continue;
    lost.push_back(&task);
    if (found == states.end()) forgotten.insert(task.id);
  }
  const std::map<std::string, std::string> accounted = accounted_states(forgotten);
  for (Task* task : lost) {
    const auto& known = forgotten.contains(task->id) ? accounted : states;
    const auto found = known.find(task->id);
    check_may_repeat(*task, found == known.end() ? "" : found->second);
    task->due = true;
    task->id.clear();
  }
  for (Task& task : tasks_) {
    if (!task.waits() || !task.before->due) continue;
    task.due = true;
    task.id.clear();
  }
}

/// One look at the marks and the queue; submits what no job does.
void Jobs::look() {
  std::set<std::string> jobs, tasks;  // that are still waited for
  std::exception_ptr failure;         // the first one, once all that has ended well is known
  const std::size_t passed_before = passed_.size();
  for (Task& task : tasks_) {
    if (task.ended) continue;
    try {
      if (look_for_mark(task)) continue;
    } catch (const Error&) {
      if (!failure) failure = std::current_exception();
    }
    if (task.id.empty()) continue;
    jobs.insert(task.id.substr(0, task.id.find('_')));
    tasks.insert(task.id);
  }
  if (passed_.size() > passed_before) remember();
  std::erase_if(passed_, [&](const auto& passed) {
    const auto& [task, mark] = passed;
    if (tasks.contains(task)) return false;  // Slurm may start it again, and it must not do this part again
    fs::remove(mark);
    return true;
  });
  if (failure) std::rethrow_exception(failure);
  if (all_ended()) return;
  std::map<std::string, std::string> states;
  try {
    states = task_states(jobs);
    last_answer_ = Clock::now();
  } catch (const Error& error) {
    if (Clock::now() - last_answer_ > std::chrono::minutes(5)) throw NoAnswer(error.what());
    return;  // the scheduler restarts, or is busy
  }
  find_due(states);
  submit_due();
}

void Jobs::run() {
  find_earlier_tasks();
  while (true) {
    look();
    if (all_ended()) return;
    for (const auto end = Clock::now() + slurm_.poll; Clock::now() < end;) {
      if (options_.while_waiting) options_.while_waiting();
      std::this_thread::sleep_for(std::min<std::chrono::milliseconds>(std::chrono::milliseconds(50), slurm_.poll));
    }
  }
}

/// Also forgets the tasks: the same command submits them again.
void Jobs::cancel() {
  std::set<std::string> ids;
  for (Task& task : tasks_) {
    if (!task.id.empty()) ids.insert(std::exchange(task.id, {}));
  }
  cancel_tasks(ids);
  remember();
}

}  // namespace

void run_on_slurm(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const fs::path& folder,
                  const SlurmOptions& slurm) {
  if (plans.empty()) return;
  Jobs jobs(plans, options, folder, slurm);
  try {
    jobs.run();
  } catch (const NoAnswer&) {
    throw;
  } catch (const Error&) {
    jobs.cancel();
    throw;
  } catch (...) {
    if (slurm.cancel && slurm.cancel()) jobs.cancel();
    throw;
  }
}

}  // namespace tactile::experiments
