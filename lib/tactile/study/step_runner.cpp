#include "tactile/study/step_runner.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/version.hpp"
#include "tactile/study/processes.hpp"

namespace tactile {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// What `steps/NAME.json` says; nothing is known where it is missing or damaged.
struct StepRunner::Known {
  std::string key;
  bool done = false;
  bool made_outputs = false;  ///< this step, with whatever key, has come to an end before
  nlohmann::json inputs, outputs;
  StepRecord record;
};

std::string key_of(const Step& step) { return hash_of({{"name", step.name}, {"version", version()}, {"inputs", step.inputs}}); }

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                     utc.tm_min, utc.tm_sec);
}

StepRunner::StepRunner(StepRunnerOptions options) : options_(std::move(options)) {}

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

bool StepRunner::knows(const std::string& name) const { return fs::exists(file_of(name)); }

nlohmann::json StepRunner::inputs_of(const std::string& name) const { return read(name).inputs; }

std::optional<StepRunner::Known> StepRunner::known_as_done(const Step& step) const {
  Known known = read(step.name);
  if (!known.done || known.key != key_of(step)) return std::nullopt;
  const nlohmann::json outputs = step.outputs();
  if (outputs.is_null() || outputs != known.outputs) return std::nullopt;
  return known;
}

bool StepRunner::is_done(const Step& step) const { return known_as_done(step).has_value(); }

void StepRunner::tell_of(const Step& step, bool kept) const {
  if (options_.tell) options_.tell(step.words.empty() ? step.name : step.words, kept);
}

bool StepRunner::find_done(const Step& step) {
  auto known = known_as_done(step);
  if (!known) return false;
  known->record.command = step.command;
  records_.push_back(std::move(known->record));
  tell_of(step, true);
  return true;
}

void StepRunner::begin(const Step& step) {
  write_json(file_of(step.name), {{"name", step.name},
                                  {"command", step.command},
                                  {"key", key_of(step)},
                                  {"done", false},
                                  {"made_outputs", read(step.name).made_outputs},
                                  {"inputs", step.inputs},
                                  {"outputs", nullptr},
                                  {"seconds", 0},
                                  {"finished_at", ""}});
}

void StepRunner::finish(const Step& step, double seconds) {
  const nlohmann::json outputs = step.outputs();
  if (outputs.is_null())
    throw Error(fmt::format("'{}' came to its end, but what it makes is not there or changes meanwhile",
                            step.command.empty() ? step.name : step.command));
  StepRecord record{step.name, step.command, seconds, utc_now()};
  write_json(file_of(step.name), {{"name", step.name},
                                  {"command", step.command},
                                  {"key", key_of(step)},
                                  {"done", true},
                                  {"made_outputs", true},
                                  {"inputs", step.inputs},
                                  {"outputs", outputs},
                                  {"seconds", seconds},
                                  {"finished_at", record.finished_at}});
  records_.push_back(std::move(record));
  ++done_now_;
}

void StepRunner::run(const Step& step) {
  if (step.arguments) return run_side_by_side({step});
  if (find_done(step)) return;
  begin(step);
  tell_of(step, false);
  const ProgressCallback progress = options_.new_progress ? options_.new_progress() : ProgressCallback{};
  tell(progress, 0, 0, step.words.empty() ? step.name : step.words);
  const auto begun = Clock::now();
  try {
    step.work(progress);
  } catch (const std::exception& e) {
    throw Error(fmt::format("'{}' failed: {}", step.command.empty() ? step.name : step.command, e.what()));
  }
  finish(step, std::chrono::duration<double>(Clock::now() - begun).count());
}

void StepRunner::run_side_by_side(const std::vector<Step>& steps) {
  const std::size_t first_record = records_.size();
  std::vector<const Step*> due;
  for (const Step& step : steps) {
    if (!step.arguments) {
      run(step);
    } else if (!find_done(step)) {
      due.push_back(&step);
    }
  }
  std::vector<ProcessPlan> plans;
  for (const Step* step : due) {
    const Known known = read(step->name);
    const bool begun_otherwise = !known.key.empty() && known.key != key_of(*step);
    // In this order: were the new key remembered first, what is of no use would look like the new step's own.
    plans.push_back({step->command, step->arguments({.begun_otherwise = begun_otherwise, .made_outputs = known.made_outputs}),
                     options_.folder / "logs" / (step->name + ".log")});
    begin(*step);
  }
  std::size_t ended = 0;
  const ProgressCallback progress = options_.new_progress ? options_.new_progress() : ProgressCallback{};
  const auto tell_all = [&] { tell(progress, ended, due.size(), fmt::format("{} of {} trainings", ended, due.size())); };
  run_processes(plans, {.program = options_.program,
                        .at_once = options_.threads,
                        .while_waiting = tell_all,
                        .begun = [&](std::size_t index) { tell_of(*due[index], false); },
                        .ended =
                            [&](std::size_t index, double seconds) {
                              finish(*due[index], seconds);
                              ++ended;
                            }});
  // In the order of the plan, whichever ended first.
  const auto place_of = [&](const StepRecord& record) {
    return std::find_if(steps.begin(), steps.end(), [&](const Step& step) { return step.name == record.name; }) - steps.begin();
  };
  std::stable_sort(records_.begin() + static_cast<std::ptrdiff_t>(first_record), records_.end(),
                   [&](const StepRecord& a, const StepRecord& b) { return place_of(a) < place_of(b); });
}

}  // namespace tactile
