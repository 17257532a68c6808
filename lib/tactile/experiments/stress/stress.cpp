#include "tactile/experiments/stress/stress.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "tactile/core/command_lock.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/stress/stress_figures.hpp"
#include "tactile/experiments/stress/stress_judgements.hpp"
#include "tactile/experiments/stress/stress_table.hpp"
#include "tactile/results/whole_runs_tables.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double most_lost = 0.05;

results::StressCurve curve_of(const StressPlan& plan, const StressGroup& group, const PlannedCurve& curve) {
  const StressSeries& series = *curve.series;
  const std::vector<double> severities = severities_of(series);
  std::vector<std::vector<results::Cell>> outcomes;
  outcomes.reserve(severities.size());
  for (const double severity : severities) outcomes.push_back(cells_of(plan, judgements_at(group, curve, severity)));
  const results::BootstrapOptions& bootstrap = plan.options.judging.bootstrap;
  return {.name = series.name,
          .is_world = !series.world.empty(),
          .unit = series.unit,
          .meaning = series.meaning,
          .points = points_of(severities, outcomes, plan.options.judging.threads, bootstrap),
          .holds = holds_up_to(severities, outcomes, most_lost, bootstrap)};
}

/// The figures of a group whose judgements are done.
results::StressedModel model_of(const StressPlan& plan, const StressGroup& group) {
  results::StressedModel model{.name = group.name};
  std::set<std::string> runs;
  for (const StressTraining& training : group.trainings) {
    model.trainings.push_back(training.bundle.name());
    for (const std::string& run : training.names()) runs.insert(run);
  }
  model.runs.assign(runs.begin(), runs.end());
  for (const PlannedCurve& curve : curves_of(plan, group))
    (curve.runs == JudgedRuns::quiet ? model.quiet : model.curves).push_back(curve_of(plan, group, curve));
  return model;
}

/// Runs that no training, or not every one, was judged on.
std::vector<results::LeftOutRun> left_out_of(const StressPlan& plan) {
  std::map<std::string, std::string> left_out;
  for (const StressGroup& group : plan.groups) {
    std::set<std::pair<std::size_t, std::string>> judged;
    if (has_runs(group)) {
      for (const results::Cell& cell : cells_of(plan, unchanged_runs(group)))
        judged.emplace(cell.training, cell.object + "/" + cell.run);
    }
    for (std::size_t i = 0; i < group.trainings.size(); ++i) {
      for (const results::LeftOutRun& run : group.trainings[i].left_out) left_out.emplace(run.run, run.why);
      for (const std::string& name : group.trainings[i].names()) {
        if (!judged.contains({i, name})) left_out.emplace(name, "it cannot be read; 'tactile info' says what is wrong");
      }
    }
  }
  std::vector<results::LeftOutRun> all;
  all.reserve(left_out.size());
  for (const auto& [run, why] : left_out) all.push_back({run, why});
  return all;
}

std::string judged_by(const StressPlan& plan) {
  const std::size_t trainings = plan.options.models.size();
  std::string text =
      "Judged as 'tactile eval' does, on every run that the model did not learn from: accuracy by the labels of the unchanged "
      "runs with samples, delays and false alarms by their truth where they are simulated. An event that a recipe delays counts "
      "when it arrives: its delay is part of the detection delay.";
  text += results::left_out_in_words(left_out_of(plan));
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
                         .engine = std::string(name_of(options.engine)),
                         .bootstrap = judging.bootstrap,
                         .models = std::move(models),
                         .settings = settings_json(plan),
                         .software = experiments::software_json(),
                         .machine = experiments::machine_json(judging.threads),
                         .steps = runner.records()};
  for (const fs::path& file : options.quiet) stress.quiet_files.push_back(file.filename().string());
  return stress;
}

}  // namespace

StressSummary run_stress(const StressOptions& requested, const experiments::NewProgress& new_progress,
                         const experiments::StepCallback& on_step) {
  StressOptions options = requested;
  options.judging.threads = threads_or_all(options.judging.threads);
  const StressPlan plan = plan_stress(options);
  const CommandLock lock(options.out, "tactile stress");
  if (options.force) fs::remove_all(options.out / "steps");
  experiments::StepRunner runner({.folder = options.out,
                                  .program = options.program,
                                  .threads = options.judging.threads,
                                  .new_progress = new_progress,
                                  .on_step = on_step,
                                  .slurm = options.slurm});
  runner.run_side_by_side(steps_of(plan));
  std::vector<results::StressedModel> models;
  for (const StressGroup& group : plan.groups) models.push_back(model_of(plan, group));
  const results::Stress stress = result_of(plan, std::move(models), runner);
  write_whole(options.out / "stress.csv", stress_csv(stress));
  write_whole(options.out / "stress.json", json_text(json(stress), 2) + "\n");
  return {.stress = stress, .file = options.out / "stress.json", .done = runner.done_now(), .kept = runner.kept()};
}

}  // namespace tactile::stress
