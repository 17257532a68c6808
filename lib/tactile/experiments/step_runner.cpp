#include "tactile/experiments/step_runner.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/utc_time.hpp"
#include "tactile/experiments/processes.hpp"

namespace tactile::experiments {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

const std::string& command_or_name(const Step& step) { return step.command.empty() ? step.name : step.command; }
const std::string& description_or_name(const Step& step) { return step.description.empty() ? step.name : step.description; }

nlohmann::json all_inputs(const Step& step) {
  nlohmann::json inputs = step.inputs;
  if (step.later_inputs) inputs.update(step.later_inputs());
  return inputs;
}

}  // namespace

/// The contents of `steps/NAME.json`; empty if the file is missing or damaged.
struct StepRunner::Known {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::string key;
  bool done = false;
  bool made_outputs = false;  ///< this step was done before, with any key
  nlohmann::json inputs, outputs;
  results::StepRecord record;
};

/// A process that is to run.
struct StepRunner::DueStep {
  const Step* step;
  const Step* before;                ///< the step that must be done first; null: none
  std::optional<std::size_t> after;  ///< the place of that step among those that are to run; nothing: it is done
};

namespace {

/// How many processes of a kind are to run, and have ended.
struct KindCount {
  std::string kind;
  std::size_t ended = 0, all = 0;
};

/// "3 of 11 trainings, 2 of 11 judgements"
std::string text_of(const std::vector<KindCount>& counts) {
  std::string text;
  for (const KindCount& count : counts)
    text += fmt::format("{}{} of {} {}s", text.empty() ? "" : ", ", count.ended, count.all, count.kind);
  return text;
}

KindCount& count_of(std::vector<KindCount>& counts, const std::string& kind) {
  const auto found = std::find_if(counts.begin(), counts.end(), [&](const KindCount& count) { return count.kind == kind; });
  return found != counts.end() ? *found : counts.emplace_back(KindCount{.kind = kind});
}

}  // namespace

std::string key_of(const Step& step) {
  // Later versions do what this one did, but for the last digits of weights. Raise it where a step does something else.
  constexpr const char* steps_since = "0.1.0";
  return hash_of({{"name", step.name}, {"version", steps_since}, {"inputs", all_inputs(step)}});
}

StepRunner::StepRunner(StepRunnerOptions options) : options_(std::move(options)) {
  if (options_.slurm) check_slurm(*options_.slurm, slurm_folder());  // before hours of work here
}

fs::path StepRunner::file_of(const std::string& name) const { return options_.folder / "steps" / (name + ".json"); }

StepRunner::Known StepRunner::read(const std::string& name) const {
  Known known;
  if (!fs::exists(file_of(name))) return known;
  try {
    const std::string where = file_of(name).string();
    const nlohmann::json json = read_json(file_of(name));
    known.key = member<std::string>(json, "key", where);
    known.done = member<bool>(json, "done", where);
    known.made_outputs = member<bool>(json, "made_outputs", where);
    known.inputs = member<nlohmann::json>(json, "inputs", where);
    known.outputs = member<nlohmann::json>(json, "outputs", where);
    known.record = {name, member<std::string>(json, "command", where), member<double>(json, "seconds", where),
                    member<std::string>(json, "finished_at", where)};
  } catch (const Error&) {
    return {};
  }
  return known;
}

void StepRunner::write(const Step& step, const Known& known) const {
  write_json(file_of(step.name), {{"name", step.name},
                                  {"command", step.command},
                                  {"key", key_of(step)},
                                  {"done", known.done},
                                  {"made_outputs", known.made_outputs},
                                  {"inputs", all_inputs(step)},
                                  {"outputs", known.outputs},
                                  {"seconds", known.record.seconds},
                                  {"finished_at", known.record.finished_at}});
}

nlohmann::json StepRunner::inputs_of(const std::string& name) const { return read(name).inputs; }

std::optional<StepRunner::Known> StepRunner::known_as_done(const Step& step) const {
  Known known = read(step.name);
  if (!known.done || known.key != key_of(step)) return std::nullopt;
  const nlohmann::json outputs = step.outputs();
  if (outputs.is_null() || outputs != known.outputs) return std::nullopt;
  return known;
}

bool StepRunner::is_done(const Step& step) const { return known_as_done(step).has_value(); }

void StepRunner::report(const Step& step, bool kept) const {
  if (options_.on_step) options_.on_step(description_or_name(step), kept);
}

bool StepRunner::find_done(const Step& step) {
  auto known = known_as_done(step);
  if (!known) return false;
  known->record.command = step.command;
  records_.push_back(std::move(known->record));
  report(step, true);
  return true;
}

void StepRunner::begin(const Step& step) const {
  Known begun;
  begun.made_outputs = read(step.name).made_outputs;
  write(step, begun);
}

void StepRunner::finish(const Step& step, double seconds) {
  Known known;
  known.outputs = step.outputs();
  if (known.outputs.is_null())
    throw Error(fmt::format("'{}' ended, but its outputs are missing or changed meanwhile", command_or_name(step)));
  known.done = known.made_outputs = true;
  known.record = {step.name, step.command, seconds, now_utc()};
  write(step, known);
  records_.push_back(std::move(known.record));
  ++done_now_;
}

void StepRunner::run(const Step& step) {
  if (is_a_process(step)) return run_side_by_side({step});
  if (find_done(step)) return;
  begin(step);
  report(step, false);
  const ProgressCallback progress = options_.new_progress ? options_.new_progress() : ProgressCallback{};
  report_progress(progress, 0, 0, description_or_name(step));
  const auto begun = Clock::now();
  try {
    step.work(progress);
  } catch (const std::exception& e) {
    throw Error(fmt::format("'{}' failed: {}", command_or_name(step), e.what()));
  }
  finish(step, std::chrono::duration<double>(Clock::now() - begun).count());
}

void StepRunner::run_side_by_side(const std::vector<Step>& steps) {
  const std::size_t first_record = records_.size();
  std::vector<DueStep> due;
  std::map<std::string, std::size_t> places, places_of_due;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    const auto before = places.find(step.after), due_before = places_of_due.find(step.after);
    if (!step.after.empty() && (before == places.end() || !is_a_process(step)))
      throw Error(fmt::format("'{}' comes after '{}'; expected two processes, and the other one earlier", step.name, step.after));
    places.emplace(step.name, i);
    if (!is_a_process(step)) {
      run(step);
    } else if (due_before != places_of_due.end() || !find_done(step)) {
      places_of_due.emplace(step.name, due.size());
      due.push_back({&step, before == places.end() ? nullptr : &steps[before->second],
                     due_before == places_of_due.end() ? std::nullopt : std::optional(due_before->second)});
    }
  }
  run_processes_of(due);
  // In the order of `steps`, whichever ended first.
  std::stable_sort(
      records_.begin() + static_cast<std::ptrdiff_t>(first_record), records_.end(),
      [&](const results::StepRecord& a, const results::StepRecord& b) { return places.at(a.name) < places.at(b.name); });
}

/// Without its arguments.
ProcessPlan StepRunner::plan_of(const DueStep& due) const {
  const Step& step = *due.step;
  // Not all inputs are known before the step `after` is done. Its key stands for them, also later: so the task is found again.
  const std::string key =
      due.before ? hash_of({{"name", step.name}, {"inputs", step.inputs}, {"after", key_of(*due.before)}}) : key_of(step);
  return {.name = command_or_name(step),
          .arguments = {},
          .log = options_.folder / "logs" / (step.name + ".log"),
          .key = key,
          .after = due.after};
}

/// A folder that machines share may show late what another one wrote: NFS keeps what it has seen for at most a minute.
void StepRunner::wait_for_files_of(const Step& step, const std::function<void()>& while_waiting) {
  for (const auto end = Clock::now() + std::chrono::minutes(1); files_may_be_late_ && step.outputs().is_null();) {
    files_may_be_late_ = Clock::now() < end;
    while_waiting();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

std::vector<std::string> StepRunner::arguments_of(const DueStep& due, unsigned threads) const {
  const Step& step = *due.step;
  if (!step.arguments) return step.on_cluster();
  const Known known = read(step.name);
  const bool other_inputs = !due.after && !known.key.empty() && known.key != key_of(step);
  return step.arguments({other_inputs, known.made_outputs, threads});
}

void StepRunner::run_processes_of(const std::vector<DueStep>& due) {
  const auto at_first = std::count_if(due.begin(), due.end(), [](const DueStep& one) { return !one.after; });
  const auto share = static_cast<unsigned>(options_.threads / std::max<std::size_t>(static_cast<std::size_t>(at_first), 1));
  const unsigned threads_each = options_.slurm ? 1 : std::max(1U, share);
  std::vector<ProcessPlan> plans;
  std::vector<KindCount> counts;
  for (const DueStep& one : due) {
    plans.push_back(plan_of(one));
    ++count_of(counts, one.step->kind).all;
  }
  std::size_t ended = 0;
  std::string queue;
  const ProgressCallback progress = options_.new_progress ? options_.new_progress() : ProgressCallback{};
  const auto show_progress = [&] {
    report_progress(progress, ended, due.size(), text_of(counts) + (queue.empty() ? "" : "; " + queue));
  };
  const ProcessesOptions how{.program = options_.program,
                             .at_once = options_.threads,
                             .while_waiting = show_progress,
                             .begun =
                                 [&](std::size_t index) {
                                   if (due[index].after) begin(*due[index].step);
                                   report(*due[index].step, false);
                                 },
                             .ended =
                                 [&](std::size_t index, double seconds) {
                                   if (options_.slurm) wait_for_files_of(*due[index].step, show_progress);
                                   finish(*due[index].step, seconds);
                                   ++count_of(counts, due[index].step->kind).ended;
                                   ++ended;
                                 },
                             .prepare =
                                 [&] {
                                   // First `arguments` removes leftovers that are of no use, then `begin` writes the new key. In
                                   // the other order, an interruption in between would make the leftovers look like the step's
                                   // own.
                                   for (std::size_t i = 0; i < due.size(); ++i) {
                                     plans[i].arguments = arguments_of(due[i], threads_each);
                                     if (!due[i].after) begin(*due[i].step);
                                   }
                                 },
                             .queue = [&](const std::string& text) { queue = text; }};
  if (options_.slurm) return run_on_slurm(plans, how, slurm_folder(), *options_.slurm);
  how.prepare();
  run_processes(plans, how);
}

std::vector<nlohmann::json> step_records(const fs::path& experiment, std::string_view begin) {
  std::vector<nlohmann::json> records;
  std::error_code none;
  for (fs::directory_iterator entry(experiment / "steps", none), end; !none && entry != end; entry.increment(none)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin) || entry->path().extension() != ".json") continue;
    try {
      records.push_back(read_json(entry->path()));
    } catch (const Error&) {
      // Its step is done again.
    }
  }
  return records;
}

}  // namespace tactile::experiments
