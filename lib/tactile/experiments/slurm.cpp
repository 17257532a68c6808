#include "tactile/experiments/slurm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/slurm_commands.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// What a task leaves when its process has ended.
struct Mark {
  std::string key;
  int code = 0;  ///< 128 and more: the number of the signal that ended it, plus 128, as shells have it
  double seconds = 0;

  bool is_of_signal() const { return code >= 128; }
};

/// A process as a task of a job.
struct Task {
  std::size_t index = 0;   ///< in the plans
  std::string name;        ///< of its files
  std::string id;          ///< "12_3"
  Task* before = nullptr;  ///< must succeed first
  bool depends = false;    ///< was submitted before that one had ended: Slurm cancels it if that one ends otherwise
  bool due = false;        ///< to be submitted
  unsigned attempts = 0;
  unsigned looks_without_it = 0;  ///< at which Slurm did not run it, and there was no mark
  bool begun = false, ended = false;
};

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
  void remember() const;
  void submit_due();
  void submit(const std::map<std::size_t, Task*>& tasks, const std::string& after);
  std::string script_of(const std::map<std::size_t, Task*>& tasks) const;
  void look();
  bool look_for_mark(Task& task);
  void find_due(const std::map<std::string, std::string>& states);
  void check_may_repeat(const Task& task, const std::string& state) const;

  const std::vector<ProcessPlan>& plans_;
  const ProcessesOptions& options_;
  fs::path folder_;
  const SlurmOptions& slurm_;
  std::vector<Task> tasks_;
  Clock::time_point last_answer_ = Clock::now();
};

std::optional<Mark> Jobs::read_mark(const Task& task) const {
  std::ifstream file(mark_of(task));
  Mark mark;
  double milliseconds = 0;
  if (!(file >> mark.key >> mark.code >> milliseconds) || mark.key != plans_[task.index].key) return std::nullopt;
  mark.seconds = milliseconds / 1e3;
  return mark;
}

/// Takes over tasks of this work that were submitted before, and cancels those of the same names with other work: they would
/// write the same files. Files that cannot be read mean that there are none.
void Jobs::find_earlier_tasks() {
  nlohmann::json jobs;
  try {
    jobs = read_json(folder_ / "jobs.json");
  } catch (const Error&) {
    return;
  }
  std::vector<std::string> others;
  for (Task& task : tasks_) {
    const auto found = jobs.find(task.name);
    if (found == jobs.end() || !found->is_object()) continue;
    const bool is_this_work = found->value("key", "") == plans_[task.index].key;
    if (is_this_work) {
      task.id = found->value("task", "");
      task.depends = task.before != nullptr;
    } else if (const std::string id = found->value("task", ""); !id.empty()) {
      others.push_back(id);
    }
  }
  cancel_tasks(others);
}

void Jobs::remember() const {
  nlohmann::json jobs = nlohmann::json::object();
  for (const Task& task : tasks_) {
    if (!task.id.empty()) jobs[task.name] = {{"key", plans_[task.index].key}, {"task", task.id}};
  }
  write_json(folder_ / "jobs.json", jobs);
}

/// One branch for each task, by its number in the array. Its mark appears in one step.
std::string Jobs::script_of(const std::map<std::size_t, Task*>& tasks) const {
  std::string script = fmt::format(
      "#!/bin/sh\n"
      "# The tasks of a job array.\n"
      "cd {} || exit 1\n"
      "run() {{  # NAME KEY LOG PROGRAM WORD...\n"
      "  name=$1 key=$2 log=$3\n"
      "  shift 3\n"
      "  begun=$(date +%s%N)\n"
      "  \"$@\" </dev/null >/dev/null 2>\"$log\"\n"
      "  code=$?\n"
      "  mark={}/$name\n"
      "  echo \"$key $code $((($(date +%s%N) - begun) / 1000000))\" >\"$mark.part$$\" && mv \"$mark.part$$\" \"$mark\"\n"
      "  return $code\n"
      "}}\n"
      "case $SLURM_ARRAY_TASK_ID in\n",
      shell_word(fs::current_path().string()), shell_word((folder_ / "ended").string()));
  for (const auto& [number, task] : tasks) {
    const ProcessPlan& plan = plans_[task->index];
    script += fmt::format("{}) run {} {} {} {}", number, shell_word(task->name), shell_word(plan.key),
                          shell_word(fs::absolute(plan.log).string()), shell_word(options_.program.string()));
    for (const std::string& word : plan.arguments) script += " " + shell_word(word);
    script += " ;;\n";
  }
  return script + "esac\n";
}

/// Submits tasks by their numbers in an array. @param after  the job whose tasks of the same numbers come first; empty: none
void Jobs::submit(const std::map<std::size_t, Task*>& tasks, const std::string& after) {
  std::vector<std::size_t> numbers;
  for (const auto& [number, task] : tasks) {
    numbers.push_back(number);
    fs::remove(mark_of(*task));
    fs::create_directories(plans_[task->index].log.parent_path());
  }
  const std::string text = script_of(tasks);
  const fs::path script = folder_ / (sha256_of(text).substr(0, 12) + ".sh");
  write_whole(script, text);
  std::vector<std::string> words{"--job-name=tactile", "--requeue",          "--ntasks=1",
                                 "--cpus-per-task=1",  "--open-mode=append", "--output=" + (folder_ / "slurm.log").string()};
  if (!slurm_.partition.empty()) words.push_back("--partition=" + slurm_.partition);
  words.insert(words.end(), slurm_.sbatch.begin(), slurm_.sbatch.end());
  if (!after.empty()) words.insert(words.end(), {"--dependency=aftercorr:" + after, "--kill-on-invalid-dep=yes"});
  const std::string job = submit_array(script, numbers, words);
  for (const auto& [number, task] : tasks) {
    task->id = fmt::format("{}_{}", job, number);
    task->depends = !after.empty();
    task->due = false;
    task->looks_without_it = 0;
    task->attempts = task->depends ? 1 : task->attempts + 1;
  }
  remember();
}

void Jobs::submit_due() {
  if (std::none_of(tasks_.begin(), tasks_.end(), [](const Task& task) { return task.due; })) return;
  std::map<std::size_t, Task*> tasks;
  std::vector<Task*> dependent;
  std::vector<std::string> outdated;  // they depend on a task that is submitted again
  const std::size_t most = largest_array();
  for (Task& task : tasks_) {
    if (!task.due) continue;
    if (task.before && !task.before->ended) {
      dependent.push_back(&task);
      if (!task.id.empty()) outdated.push_back(task.id);
      continue;
    }
    tasks.emplace(tasks.size(), &task);
    if (tasks.size() == most) submit(std::exchange(tasks, {}), "");
  }
  if (!tasks.empty()) submit(tasks, "");
  cancel_tasks(outdated);
  std::map<std::string, std::map<std::size_t, Task*>> by_job;
  for (Task* task : dependent) {
    const std::string& id = task->before->id;
    const std::size_t line = id.find('_');
    by_job[id.substr(0, line)].emplace(whole_number_in(id.substr(line + 1)).value_or(0), task);
  }
  for (const auto& [job, after_it] : by_job) submit(after_it, job);
}

/// Whether the task has ended. @throws Error  if its process failed
bool Jobs::look_for_mark(Task& task) {
  if (task.before && !task.before->ended) return false;
  if (task.id.empty()) return false;  // of work that was done long ago, and is due again
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
  task.id.clear();
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
  const bool by_slurm = state == "CANCELLED" && task.depends;
  if (state == "CANCELLED" && !by_slurm) throw Error(fmt::format("'{}' failed: job {} was cancelled", name, task.id));
  if (const std::optional<Mark> mark = read_mark(task); state == "FAILED" && mark && mark->is_of_signal()) {
    if (task.attempts < slurm_.attempts) return;
    throw Error(fmt::format("'{}' failed: it was started {} times, and signal {} ended it the last time; if memory was short, "
                            "expected --sbatch with more, such as \"--mem=4G\" (its log: {})",
                            name, task.attempts, mark->code - 128, plans_[task.index].log.string()));
  }
  if (!by_slurm && !may_repeat.contains(state))
    throw Error(fmt::format("'{}' failed: Slurm ended job {} as {}, and there is no {}; expected a folder that all nodes share "
                            "(what Slurm printed: {})", name, task.id, state, mark_of(task).string(), (folder_ / "slurm.log").string()));
  if (task.attempts >= slurm_.attempts)
    throw Error(fmt::format("'{}' failed: Slurm ended it {} times, the last time as {}; expected more time or other nodes, by "
                            "--sbatch", name, task.attempts, state.empty() ? "forgotten" : state));
  // clang-format on
}

/// Tasks that Slurm no longer runs, and whose process has not ended by itself, are due again: a mark may reach this machine some
/// seconds late. A task that comes after one that is due is due with it.
void Jobs::find_due(const std::map<std::string, std::string>& states) {
  static const std::set<std::string> alive{"PENDING",  "RUNNING",   "SUSPENDED", "COMPLETING", "CONFIGURING",  "REQUEUED",
                                           "RESIZING", "SIGNALING", "STAGE_OUT", "STOPPED",    "REQUEUE_HOLD", "REQUEUE_FED"};
  constexpr unsigned patience = 4;
  std::vector<const Task*> lost;
  std::set<std::string> forgotten;  // of the lost ones, by squeue
  for (Task& task : tasks_) {
    if (task.ended) continue;
    if (task.before && !task.before->ended) {
      task.due = task.id.empty() || task.before->due;
      continue;
    }
    const auto found = states.find(task.id);
    if (found != states.end() && alive.contains(found->second)) {
      task.looks_without_it = 0;
      if (found->second == "RUNNING" && !task.begun) {
        task.begun = true;
        if (options_.begun) options_.begun(task.index);
      }
      continue;
    }
    if (!task.id.empty() && ++task.looks_without_it < patience) continue;
    task.due = true;
    if (task.id.empty()) continue;
    lost.push_back(&task);
    if (found == states.end()) forgotten.insert(task.id);
  }
  const std::map<std::string, std::string> accounted = accounted_states(forgotten);
  for (const Task* task : lost) {
    const auto& known = forgotten.contains(task->id) ? accounted : states;
    const auto found = known.find(task->id);
    check_may_repeat(*task, found == known.end() ? "" : found->second);
  }
}

/// One look at the marks and the queue; submits what no job does.
void Jobs::look() {
  std::set<std::string> jobs;
  std::vector<fs::path> used_marks;
  for (Task& task : tasks_) {
    if (task.ended) continue;
    if (look_for_mark(task)) {
      used_marks.push_back(mark_of(task));
    } else if (!task.id.empty()) {
      jobs.insert(task.id.substr(0, task.id.find('_')));
    }
  }
  if (!used_marks.empty()) remember();
  for (const fs::path& mark : used_marks) fs::remove(mark);
  if (all_ended()) return;
  std::map<std::string, std::string> states;
  try {
    states = task_states(jobs);
    last_answer_ = Clock::now();
  } catch (const Error&) {
    if (Clock::now() - last_answer_ > std::chrono::minutes(5)) throw;
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
  std::vector<std::string> ids;
  for (Task& task : tasks_) {
    if (!task.id.empty()) ids.push_back(std::exchange(task.id, {}));
  }
  cancel_tasks(ids);
  remember();
}

}  // namespace

SlurmOptions slurm_named(const std::string& name) {
  const std::string begin = "slurm";
  SlurmOptions options;
  if (name == begin) return options;
  if (name.starts_with(begin + ":") && name.size() > begin.size() + 1) {
    options.partition = name.substr(begin.size() + 1);
    return options;
  }
  throw Error(fmt::format("executor '{}': expected local, slurm or slurm:PARTITION", name));
}

void run_on_slurm(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const fs::path& folder,
                  const SlurmOptions& slurm) {
  if (plans.empty()) return;
  Jobs jobs(plans, options, folder, slurm);
  try {
    jobs.run();
  } catch (const Error&) {
    jobs.cancel();
    throw;
  } catch (...) {
    if (slurm.cancel && slurm.cancel()) jobs.cancel();
    throw;
  }
}

}  // namespace tactile::experiments
