#include "tactile/experiments/stress/stress.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "tactile/core/command_lock.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/stress/judge_runs.hpp"
#include "tactile/experiments/stress/stress_figures.hpp"
#include "tactile/experiments/stress/stress_table.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double most_lost = 0.05;
constexpr double harmless = 0;

/// What the runs of one step are: of the dataset, by labels or truth, or quiet ones.
enum class Runs : std::uint8_t { by_labels, by_truth, quiet };

/// Judges trainings in steps that are kept.
class Judge {
 public:
  Judge(const StressPlan& plan, experiments::StepRunner& runner) : plan_(plan), runner_(runner) {}

  /// The outcomes of all trainings of a group. @param series  nothing: unchanged runs
  std::vector<RunOutcome> outcomes(const StressGroup& group, const StressSeries* series, double severity, Runs runs) {
    std::vector<RunOutcome> all;
    for (std::size_t i = 0; i < group.trainings.size(); ++i) {
      const fs::path file = run(group.trainings[i], series, severity, runs);
      for (RunOutcome& outcome : read_outcomes(file, i)) all.push_back(std::move(outcome));
    }
    return all;
  }

 private:
  fs::path run(const StressTraining& training, const StressSeries* series, double severity, Runs runs) {
    const std::string at = series ? fmt::format("{}-{:g}", series->name, severity) : runs == Runs::by_truth ? "truth" : "clean";
    const std::string name = fmt::format("{}{}-{}", runs == Runs::quiet ? "quiet-" : "", training.bundle.name(), at);
    const fs::path file = plan_.options.out / "judged" / (name + ".json");
    const auto judge = [&, file, severity, runs](const ProgressCallback& progress) {
      const JudgedBy by = runs == Runs::by_truth ? JudgedBy::truth : JudgedBy::labels;
      write_outcomes(file, runs == Runs::quiet ? judged_quiet(plan_, training, series, severity, progress)
                                               : judged_runs(plan_, training, series, severity, by, progress));
    };
    const std::string of = plan_.options.models.size() > 1 ? training.bundle.name() + ", " : "";
    const std::string what = series ? fmt::format("{} {:g} {}", series->name, severity, series->unit)
                                    : "unchanged, judged by their " + std::string(runs == Runs::by_truth ? "truth" : "labels");
    if (!seen_.insert(name).second) return file;  // the unchanged runs begin every curve
    runner_.run(experiments::file_step(name, inputs(training, series, severity, runs), file, judge,
                                       fmt::format("{}{}: {}", of, runs == Runs::quiet ? "quiet recordings" : "runs", what)));
    return file;
  }

  json inputs(const StressTraining& training, const StressSeries* series, double severity, Runs runs) const {
    const evaluation::EvaluationOptions& judging = plan_.options.judging;
    json of = {{"weights", training.description.weights_sha256},
               {"confirm", text_of(judging.confirmation)},
               {"alarm_cost", judging.alarm_cost ? json(*judging.alarm_cost) : json()},
               {"temperature", experiments::hash_of_file(model::temperature_file(training.bundle))},
               {"gate", judging.gate},
               {"engine", name_of(plan_.options.engine)},
               {"by", static_cast<int>(runs)},
               {"series", series ? json_of(*series, severity) : json()}};
    if (runs == Runs::quiet) {
      of["files"] = json::array();
      for (const fs::path& file : plan_.options.quiet) of["files"].push_back({file.filename().string(), hash_of(file)});
    } else {
      of["manifest"] = plan_.dataset->manifest_hash();
      of["runs"] = names_of(*plan_.dataset, training.runs);
      of["truth"] = experiments::truth_hashes(*plan_.dataset, training.runs);
    }
    return of;
  }

  /// Of a recording, computed once.
  json hash_of(const fs::path& file) const {
    auto& hash = hashes_[file];
    if (hash.is_null()) hash = experiments::hash_of_file(file);
    return hash;
  }

  const StressPlan& plan_;
  experiments::StepRunner& runner_;
  std::set<std::string> seen_;  ///< steps that were run or found done
  mutable std::map<fs::path, json> hashes_;
};

results::StressCurve curve_of(const StressPlan& plan, Judge& judge, const StressGroup& group, const StressSeries& series,
                              bool is_quiet) {
  const bool is_world = !series.world.empty();
  const Runs runs = is_quiet ? Runs::quiet : is_world ? Runs::by_truth : Runs::by_labels;
  std::vector<double> severities{harmless};
  std::vector<std::vector<RunOutcome>> outcomes{judge.outcomes(group, nullptr, harmless, runs)};
  for (const double severity : series.severities) {
    severities.push_back(severity);
    outcomes.push_back(judge.outcomes(group, &series, severity, runs));
  }
  const results::BootstrapOptions& bootstrap = plan.options.judging.bootstrap;
  return {.name = series.name,
          .is_world = is_world,
          .unit = series.unit,
          .meaning = series.meaning,
          .points = points_of(severities, outcomes, plan.options.judging.threads, bootstrap),
          .holds = holds_up_to(severities, outcomes, most_lost, bootstrap)};
}

results::StressedModel model_of(const StressPlan& plan, Judge& judge, const StressGroup& group) {
  results::StressedModel model{.name = group.name};
  std::set<std::string> runs;
  for (const StressTraining& training : group.trainings) {
    model.trainings.push_back(training.bundle.name());
    for (const std::uint32_t run : training.runs) runs.insert(name_of(plan.dataset->runs()[run]));
  }
  model.runs.assign(runs.begin(), runs.end());
  for (const StressSeries& series : plan.options.series) {
    if (!runs.empty()) model.curves.push_back(curve_of(plan, judge, group, series, false));
    if (!plan.options.quiet.empty() && series.world.empty()) model.quiet.push_back(curve_of(plan, judge, group, series, true));
  }
  if (!runs.empty()) {
    for (const RunOutcome& outcome : judge.outcomes(group, nullptr, harmless, Runs::by_labels))
      model.close_ticks += outcome.close_ticks;
  }
  return model;
}

std::string judged_by(const StressPlan& plan) {
  const std::size_t trainings = plan.options.models.size();
  std::string text =
      "Judged as 'tactile eval' does, by the labels of the unchanged runs, on runs that the model did not learn from. An event "
      "that "
      "a recipe delays counts when it arrives: its delay is part of the detection delay.";
  if (std::any_of(plan.options.series.begin(), plan.options.series.end(), [](const auto& one) { return !one.world.empty(); }))
    text +=
        " Runs of simulated worlds are simulated again with the same seed, and judged by their truth; so is their severity 0.";
  if (!plan.options.quiet.empty()) text += " In quiet recordings every alarm is false.";
  text += trainings == plan.groups.size() ? " Intervals are over objects and runs, and hold for one training."
                                          : " Intervals are over trainings, objects and runs.";
  return text;
}

json settings_json(const StressPlan& plan) {
  const StressOptions& options = plan.options;
  json series = json::array();
  for (const StressSeries& one : options.series) {
    json severities = json::array();
    for (const double severity : one.severities) severities.push_back(json_of(one, severity));
    series.push_back({{"name", one.name}, {"at", severities}});
  }
  return {{"dataset", options.dataset ? json(experiments::from_folder(*options.dataset, options.out)) : json()},
          {"runs_per_object", options.runs ? json(*options.runs) : json()},
          {"series", series}};
}

results::Stress result_of(const StressPlan& plan, std::vector<results::StressedModel> models,
                          const experiments::StepRunner& runner) {
  const StressOptions& options = plan.options;
  const evaluation::EvaluationOptions& judging = options.judging;
  const bool simulated = plan.dataset && plan.dataset->simulated();
  results::Stress stress{.title = plan.dataset ? fmt::format("{} runs that are worsened", simulated ? "Simulated" : "Real")
                                               : "Quiet recordings that are worsened",
                         .simulated = simulated,
                         .judged_by = judged_by(plan),
                         .manifest_hash = plan.dataset ? plan.dataset->manifest_hash() : "",
                         .seed = options.seed,
                         .most_lost = most_lost,
                         .confirm = text_of(judging.confirmation),
                         .alarm_cost = judging.alarm_cost,
                         .gate = judging.gate,
                         .engine = std::string(name_of(options.engine)),
                         .bootstrap = judging.bootstrap,
                         .models = std::move(models),
                         .settings = settings_json(plan),
                         .software = experiments::software_json(),
                         .machine = experiments::machine_json(judging.threads),
                         .steps = experiments::steps_json(runner.records())};
  for (const fs::path& file : options.quiet) stress.quiet_files.push_back(file.filename().string());
  return stress;
}

}  // namespace

StressSummary run_stress(const StressOptions& requested, const experiments::NewProgress& new_progress,
                         const experiments::StepCallback& on_step) {
  StressOptions options = requested;
  options.judging.threads = evaluation::threads_or_all(options.judging.threads);
  const StressPlan plan = plan_stress(options);
  const CommandLock lock(options.out, "tactile stress");
  if (options.force) fs::remove_all(options.out / "steps");
  experiments::StepRunner runner({.folder = options.out,
                                  .program = "/proc/self/exe",
                                  .threads = options.judging.threads,
                                  .new_progress = new_progress,
                                  .on_step = on_step});
  Judge judge(plan, runner);
  std::vector<results::StressedModel> models;
  for (const StressGroup& group : plan.groups) models.push_back(model_of(plan, judge, group));
  const results::Stress stress = result_of(plan, std::move(models), runner);
  write_whole(options.out / "stress.csv", stress_csv(stress));
  write_whole(options.out / "stress.json", json_text(json(stress), 2) + "\n");
  return {.stress = stress, .file = options.out / "stress.json", .done = runner.done_now(), .kept = runner.kept()};
}

}  // namespace tactile::stress
