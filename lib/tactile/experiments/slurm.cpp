#include "tactile/experiments/slurm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/slurm_commands.hpp"
#include "tactile/experiments/slurm_script.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto patience_without_answer = std::chrono::minutes(5);
constexpr const char* jobs_file = "jobs.json";
constexpr int form_of_jobs = 2;  ///< of the entries in jobs.json and of marks. With another number they are other work

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

/// The entries of jobs.json; none if it is missing or damaged.
nlohmann::json jobs_in(const fs::path& folder) {
  try {
    if (nlohmann::json jobs = read_json(folder / jobs_file); jobs.is_object()) return jobs;
  } catch (const Error&) {
    // No task was submitted.
  }
  return nlohmann::json::object();
}

void wait_for(std::chrono::milliseconds time, const std::function<void()>& while_waiting) {
  for (const auto end = Clock::now() + time; Clock::now() < end;) {
    if (while_waiting) while_waiting();
    std::this_thread::sleep_for(std::min<std::chrono::milliseconds>(std::chrono::milliseconds(50), time));
  }
}

/// The tasks of one call, and their files in `folder`.
class Jobs {
 public:
  Jobs(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const fs::path& folder, const SlurmOptions& slurm)
      : plans_(plans), options_(options), folder_(fs::absolute(folder)), slurm_(slurm), jobs_(jobs_in(folder)) {
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
  void find_marks();
  std::optional<Mark> find_mark(const Task& task) const;
  void find_earlier_tasks();
  void remember();
  std::vector<Chain> due_chains();
  void submit_due();
  void submit(const std::vector<Chain>& chains);
  void look();
  bool look_for_mark(Task& task);
  void find_due(const std::map<std::string, QueuedTask>& queued);
  void report_queue(const std::map<std::string, QueuedTask>& queued) const;
  void check_may_repeat(const Task& task, const std::string& state) const;

  const std::vector<ProcessPlan>& plans_;
  const ProcessesOptions& options_;
  fs::path folder_;
  const SlurmOptions& slurm_;
  std::vector<Task> tasks_;
  nlohmann::json jobs_;                                   ///< jobs.json, which also has tasks of other calls
  std::vector<std::pair<std::string, fs::path>> passed_;  ///< the task and mark of processes that have succeeded
  std::set<std::string> others_;                          ///< tasks of other work that are to end
  std::set<std::string> marks_;                           ///< names of the files in `ended/`
  Clock::time_point last_answer_ = Clock::now();
  std::optional<Clock::time_point> last_ran_;  ///< when a task of this call was last in the queue
  Clock::time_point next_submission_{};        ///< after Slurm has refused one
};

/// Lists the folder, because NFS keeps for a minute that there is no file of a name, and looks again when a folder is opened.
void Jobs::find_marks() {
  marks_.clear();
  std::error_code none;
  for (fs::directory_iterator mark(folder_ / "ended", none), end; !none && mark != end; mark.increment(none))
    marks_.insert(mark->path().filename().string());
}

std::optional<Mark> Jobs::find_mark(const Task& task) const {
  if (!marks_.contains(task.name)) return std::nullopt;
  std::optional<Mark> mark = read_mark(mark_of(task));
  if (mark && (mark->key != plans_[task.index].key || mark->task != task.id)) return std::nullopt;
  return mark;
}

/// Takes over tasks of this work that were submitted before. Ends those of other work, which write the same files.
void Jobs::find_earlier_tasks() {
  for (Task& task : tasks_) {
    const auto found = jobs_.find(task.name);
    if (found == jobs_.end() || !found->is_object()) continue;
    const bool is_this_work = found->value("form", 0) == form_of_jobs && found->value("key", "") == plans_[task.index].key;
    if (is_this_work) {
      task.id = found->value("task", "");
    } else if (const std::string id = found->value("task", ""); !id.empty()) {
      others_.insert(id);
    }
  }
  for (Task& task : tasks_) {
    if (others_.contains(task.id)) task.id.clear();  // this task also does other work
  }
  if (others_.empty()) return;
  if (options_.queue) options_.queue(fmt::format("waits for {} cancelled tasks to end", others_.size()));
  if (!end_tasks(others_, std::chrono::minutes(5), [this] { wait_for(slurm_.poll, options_.while_waiting); })) {
    throw NoAnswer(
        fmt::format("Slurm does not end the cancelled tasks {}, which write the same files; expected that they end "
                    "(scontrol show job {})",
                    fmt::join(others_, ", "), *others_.begin()));
  }
  others_.clear();
  remember();
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
  write_json(folder_ / jobs_file, jobs_);
}

void Jobs::submit(const std::vector<Chain>& chains) {
  std::vector<ScriptedTask> scripted(chains.size());
  for (std::size_t i = 0; i < chains.size(); ++i) {
    for (const Task* task : chains[i]) {
      fs::create_directories(plans_[task->index].log.parent_path());
      scripted[i].push_back({task->name, &plans_[task->index]});
    }
  }
  const std::string text = script_of(scripted, options_.program, folder_ / "ended");
  const fs::path script = folder_ / (sha256_of(text).substr(0, 12) + ".sh");
  std::optional<std::string> job = live_job_of(script);  // of a call that was killed before it noted the job
  if (!job) {
    for (const Chain& chain : chains) {
      for (const Task* task : chain) fs::remove(mark_of(*task));
    }
    write_whole(script, text);
    std::vector<std::string> words = words_of(slurm_);
    words.push_back("--output=" + (folder_ / "slurm.log").string());
    job = submit_array(script, chains.size(), words);
  }
  for (std::size_t i = 0; i < chains.size(); ++i) {
    for (Task* task : chains[i]) {
      task->id = fmt::format("{}_{}", *job, i);
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
    } catch (const NoAnswer&) {
      if (Clock::now() - last_answer_ > patience_without_answer) throw;
      next_submission_ = Clock::now() + 20 * slurm_.poll;
      return;
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
  const std::optional<Mark> mark = find_mark(task);
  if (!mark || mark->is_of_signal()) return false;  // Slurm's state says why, and whether to repeat it
  const ProcessPlan& plan = plans_[task.index];
  if (mark->code != 0) {
    const std::string words = last_message(plan.log);
    throw Error(fmt::format("'{}' failed on node {}: {}", plan.name, mark->node,
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
  if (const std::optional<Mark> mark = find_mark(task); state == "FAILED" && mark && mark->is_of_signal()) {
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
/// seconds late, and the one of a task that Slurm saw succeed a minute. What comes after a task that is due is due with it.
void Jobs::find_due(const std::map<std::string, QueuedTask>& queued) {
  constexpr unsigned patience = 4, patience_with_completed = 20;
  std::vector<Task*> lost;
  std::map<std::string, std::string> states;
  std::set<std::string> forgotten;  // of the lost ones, by squeue
  for (Task& task : tasks_) {
    if (task.ended || task.waits()) continue;
    if (task.id.empty()) {
      task.due = true;
      continue;
    }
    const auto found = queued.find(task.id);
    const std::string state = found == queued.end() ? "" : found->second.state;
    if (!state.empty() && is_alive(found->second)) {
      task.looks_without_it = 0;
      last_ran_ = Clock::now();
      if (state == "RUNNING" && !task.begun) {
        task.begun = true;
        if (options_.begun) options_.begun(task.index);
      }
      continue;
    }
    if (++task.looks_without_it < (state == "COMPLETED" ? patience_with_completed : patience)) continue;
    lost.push_back(&task);
    states[task.id] = state;
    if (state.empty()) forgotten.insert(task.id);
  }
  for (const auto& [task, state] : accounted_states(forgotten)) states[task] = state;
  for (Task* task : lost) {
    check_may_repeat(*task, states.at(task->id));
    task->due = true;
    task->id.clear();
  }
  for (Task& task : tasks_) {
    if (!task.waits() || !task.before->due) continue;
    task.due = true;
    task.id.clear();
  }
}

/// "4 run, 20 wait"; if none runs, also why the first one waits: "20 wait (Resources)".
void Jobs::report_queue(const std::map<std::string, QueuedTask>& queued) const {
  if (!options_.queue) return;
  std::set<std::string> run, wait;
  std::string reason;
  for (const Task& task : tasks_) {
    const auto found = queued.find(task.id);
    if (found == queued.end() || !is_alive(found->second)) continue;
    if (found->second.state == "RUNNING") {
      run.insert(task.id);
    } else if (wait.insert(task.id).second && reason.empty() && found->second.reason != "None") {
      reason = found->second.reason;
    }
  }
  std::string text = run.empty() ? "" : fmt::format("{} run", run.size());
  if (!wait.empty()) text += fmt::format("{}{} wait", text.empty() ? "" : ", ", wait.size());
  if (run.empty() && !reason.empty()) text += fmt::format(" ({})", reason);
  options_.queue(text);
}

/// One look at the marks and the queue; submits what no job does.
void Jobs::look() {
  std::set<std::string> tasks;  // that are still waited for
  std::exception_ptr failure;   // the first one, once all that has ended well is known
  const std::size_t passed_before = passed_.size();
  find_marks();
  for (Task& task : tasks_) {
    if (task.ended) continue;
    try {
      if (look_for_mark(task)) continue;
    } catch (const Error&) {
      if (!failure) failure = std::current_exception();
    }
    if (!task.id.empty()) tasks.insert(task.id);
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
  std::map<std::string, QueuedTask> queued;
  try {
    queued = queued_tasks(tasks);
    last_answer_ = Clock::now();
  } catch (const Error& error) {
    if (Clock::now() - last_answer_ > patience_without_answer) throw NoAnswer(error.what());
    return;  // the scheduler restarts, or is busy
  }
  find_due(queued);
  report_queue(queued);
  submit_due();
}

void Jobs::run() {
  find_earlier_tasks();
  if (options_.prepare) options_.prepare();
  while (true) {
    look();
    if (all_ended()) return;
    wait_for(slurm_.poll, options_.while_waiting);
  }
}

/// Also forgets the tasks: the same command submits them again. Those that do not end soon stay known as other work.
void Jobs::cancel() {
  constexpr auto patience = std::chrono::minutes(1);  // Slurm kills what has not ended within half a minute, by default
  std::set<std::string> ids = others_;
  for (Task& task : tasks_) {
    if (task.id.empty()) continue;
    ids.insert(task.id);
    jobs_[task.name] = {{"form", form_of_jobs}, {"key", "cancelled"}, {"task", std::exchange(task.id, {})}};
  }
  if (ids.empty()) return;
  try {
    write_json(folder_ / jobs_file, jobs_);
  } catch (const Error&) {
    // The disk may be full: they are cancelled all the same.
  }
  if (end_tasks(ids, patience, [this] { wait_for(slurm_.poll, {}); })) {
    remember();
  } else if (slurm_.warn) {
    slurm_.warn(fmt::format("Slurm has not ended the cancelled tasks yet: {}", fmt::join(ids, ", ")));
  }
}

}  // namespace

void check_slurm(const SlurmOptions& slurm, const fs::path& folder) {
  try {
    test_submission(words_of(slurm));
  } catch (const JobsRefused& refused) {
    const std::string words = refused.what();
    bool may_pass = !jobs_in(folder).empty();
    for (const char* cause : {"node configuration is not available", "QOS policy", "busy"})  // no node is up; many jobs wait
      may_pass = may_pass || words.find(cause) != std::string::npos;
    if (!may_pass) throw;
    if (slurm.warn) slurm.warn(words);
  }
}

void run_on_slurm(const std::vector<ProcessPlan>& plans, const ProcessesOptions& options, const fs::path& folder,
                  const SlurmOptions& slurm) {
  if (plans.empty()) return;
  Jobs jobs(plans, options, folder, slurm);
  try {
    jobs.run();
  } catch (const NoAnswer&) {
    throw;
  } catch (const std::system_error&) {
    throw;  // of a folder that cannot be read for a while
  } catch (const Error& error) {
    if (slurm.warn) slurm.warn(fmt::format("{}; the other tasks are cancelled", error.what()));
    jobs.cancel();
    throw;
  } catch (...) {
    if (slurm.cancel && slurm.cancel()) jobs.cancel();
    throw;
  }
}

}  // namespace tactile::experiments
