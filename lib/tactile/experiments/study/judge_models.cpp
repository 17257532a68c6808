#include "tactile/experiments/study/judge_models.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int form = 7;  ///< with another number, judgements that are kept are made again

experiments::Step step_to_train(const StudyPlan& plan, const StudyModel& model) {
  const StudyOptions& options = plan.options;
  return experiments::training_step(
      plan.dataset(model), model.settings, model.bundle,
      {plan.worlds[model.world].prepared.world.data, options.models, experiments::from_folder(options.models, options.out)});
}

experiments::Step step_to_judge(const StudyPlan& plan, const StudyModel& model, const std::string& training) {
  const windows::Dataset& dataset = plan.dataset(model);
  const fs::path file = cells_file(plan, model);
  const std::vector<std::string> runs = names_of(dataset, model.runs);
  const std::string engine(name_of(plan.options.engine));
  json inputs{{"manifest", dataset.manifest_hash()}, {"runs", runs}, {"engine", engine}, {"form", form}};
  if (model.whole) {
    if (judges_baselines(model)) inputs["baselines"] = evaluation::baseline_names;
    inputs["truth"] = experiments::truth_hashes(evaluation::folders_of(dataset, model.runs));
    inputs["others"] = experiments::hashes_of_runs(evaluation::other_runs(dataset, model.runs, model.settings.split).runs);
  }
  std::vector<std::string> words{"judge", dataset.file().string(), "--model",  model.bundle.folder.string(),
                                 "--out", file.string(),           "--engine", engine};
  if (model.whole) words.emplace_back("--whole");
  if (judges_baselines(model)) words.emplace_back("--baselines");
  return {.name = "judge-" + model.name(),
          .command = "",
          .inputs = inputs,
          .after = training,
          .later_inputs =
              [bundle = model.bundle] {
                return json{{"weights", model::read_description(bundle).weights_sha256}};
              },
          .outputs = [file] { return experiments::hash_of_file(file); },
          .arguments =
              [words, runs](const experiments::StepStart& start) {
                std::vector<std::string> all = words;
                all.insert(all.end(), {"--threads", std::to_string(start.threads)});
                if (!runs.empty()) all.emplace_back("--runs");
                all.insert(all.end(), runs.begin(), runs.end());
                return all;
              },
          .kind = "judgement"};
}

/// The touches of a run: by its truth if it is simulated, else by its labels.
std::vector<TouchInterval> touches_of(const evaluation::RunTruth& truth) {
  return truth.has_truth ? truth.true_ones : truth.used();
}

bool has_press_and_slip(const evaluation::RunTruth& truth) {
  const std::vector<TouchInterval> touches = touches_of(truth);
  const auto has = [&](Touch touch) {
    return std::any_of(touches.begin(), touches.end(), [touch](const TouchInterval& one) { return one.touch == touch; });
  };
  return has(Touch::press) && has(Touch::slip);
}

bool has_firm_lift(const evaluation::RunTruth& truth) {
  return std::find(truth.causes.begin(), truth.causes.end(), "firm lift") != truth.causes.end();
}

/// The first run of the water bottle, as in the paper, for which it is so; else the first of any object.
std::optional<RunFolder> run_with(const std::vector<RunFolder>& runs, bool (*is_so)(const evaluation::RunTruth&)) {
  std::vector<RunFolder> order = runs;
  std::stable_partition(order.begin(), order.end(), [](const RunFolder& run) { return run.object == "water-bottle"; });
  const auto found =
      std::find_if(order.begin(), order.end(), [&](const RunFolder& run) { return is_so(evaluation::read_run_truth(run)); });
  return found == order.end() ? std::nullopt : std::optional(*found);
}

void predict(const StudyPlan& plan, const StudyModel& model, const RunFolder& run, const fs::path& csv_file,
             const ProgressCallback& progress) {
  const windows::Dataset& dataset = plan.dataset(model);
  const model::Classifier classifier = model::open_classifier(model.bundle.folder, plan.options.threads, plan.options.engine);
  std::map<CameraTime, Touch> samples;
  for (const windows::Sample& sample : dataset.samples()) {
    if (name_of(dataset.runs()[sample.run_index]) == run.name()) samples[sample.t] = sample.touch;
  }
  const std::size_t total = evaluation::expected_ticks(run.events(), classifier.rendering());
  std::size_t done = 0;
  const auto prediction = evaluation::predict_run(run, classifier,
                                                  {.decision = model::usual_decision(classifier.kind(), {}),
                                                   .include_flagged = plan.options.include_flagged,
                                                   .threads = plan.options.threads},
                                                  [&](std::size_t ticks) {
                                                    done += ticks;
                                                    report_progress(progress, done, total, "every tick of " + run.name());
                                                  });
  evaluation::write_prediction(csv_file, prediction, samples);
  write_json(fs::path(csv_file).replace_extension(".json"), evaluation::outcome_json(prediction));
}

results::ReportedRun predict_run(const StudyPlan& plan, const StudyModel& model, const RunFolder& run,
                                 experiments::StepRunner& runner) {
  const StudyOptions& options = plan.options;
  const fs::path folder = options.out / "runs" / model.setting;
  const fs::path csv_file = folder / (run.object + "-" + run.run + ".csv"),
                 json_file = fs::path(csv_file).replace_extension(".json");
  runner.run({.name = fmt::format("run-{}-{}-{}", model.setting, run.object, run.run),
              .command = experiments::command_of({"eval", plan.worlds[model.world].prepared.world.data.string(), "--run",
                                                  run.name(), "--models", options.models.string(), "--model", model.name(),
                                                  "--out", folder.string(), "--engine", std::string(name_of(options.engine))}),
              .inputs = {{"run", experiments::hashes_of_runs({run})},
                         {"weights", model::read_description(model.bundle).weights_sha256},
                         {"engine", name_of(options.engine)},
                         {"form", form}},
              .outputs =
                  [=] {
                    const json csv = experiments::hash_of_file(csv_file), outcome = experiments::hash_of_file(json_file);
                    return csv.is_null() || outcome.is_null() ? json() : json{csv, outcome};
                  },
              .work = [&](const ProgressCallback& progress) { predict(plan, model, run, csv_file, progress); }});
  results::ReportedRun reported{.run = run.name(), .model = model.name(), .csv = experiments::from_folder(csv_file, options.out)};
  const heatmaps::HeatmapOptions& rendering = model.settings.rendering;
  reported.history_ms = in_ms(model.settings.kind == model::ModelKind::lenet ? rendering.history : rendering.tick);
  return reported;
}

/// Of the first world and training.
const StudyModel& first_model(const StudyPlan& plan, model::ModelKind kind) {
  return *std::find_if(plan.models.begin(), plan.models.end(),
                       [&](const StudyModel& model) { return model.whole && model.settings.kind == kind; });
}

}  // namespace

bool judges_baselines(const StudyModel& model) { return model.whole && model.settings.kind == model::ModelKind::stream; }

std::string setting_of_baseline(const std::string& name, const StudyModel& model) {
  return model.settings.split.kind == windows::SplitKind::unseen ? name + "-unseen" : name;
}

fs::path cells_file(const StudyPlan& plan, const StudyModel& model) {
  return plan.options.out / "cells" / (model.name() + ".csv");
}

void train_and_judge(const StudyPlan& plan, experiments::StepRunner& runner) {
  std::vector<experiments::Step> steps;
  steps.reserve(2 * plan.models.size());
  for (const StudyModel& model : plan.models) steps.push_back(step_to_train(plan, model));
  for (std::size_t i = 0; i < plan.models.size(); ++i) steps.push_back(step_to_judge(plan, plan.models[i], steps[i].name));
  runner.run_side_by_side(steps);
}

std::vector<results::Cell> cells_of(const StudyPlan& plan) {
  std::vector<results::Cell> all;
  for (const StudyModel& model : plan.models) {
    for (results::Cell& cell : results::read_cells(cells_file(plan, model))) {
      cell.training = model.training;
      cell.setting = cell.setting.empty() ? model.setting : setting_of_baseline(cell.setting, model);
      all.push_back(std::move(cell));
    }
  }
  return all;
}

void judge(const Judgement& judgement, const ProgressCallback& progress) {
  const windows::Dataset dataset(judgement.dataset);
  const model::Classifier classifier = model::open_classifier(judgement.bundle, judgement.threads, judgement.engine);
  evaluation::ModelOnRuns on_runs{&classifier, {}};
  for (const std::string& name : judgement.runs) {
    const auto runs = dataset.runs();
    const auto found = std::find_if(runs.begin(), runs.end(), [&](const auto& run) { return name_of(run) == name; });
    if (found == runs.end()) throw Error(judgement.dataset.string() + ": has no run " + name + "; expected one of its runs");
    on_runs.runs.push_back(static_cast<std::uint32_t>(found - runs.begin()));
  }
  const evaluation::EvaluationOptions options{.thresholds = model::usual_thresholds(classifier.kind()),
                                              .threads = judgement.threads};
  write_whole(judgement.out,
              results::cells_csv(
                  judgement.whole ? evaluation::judge_whole_runs(dataset, on_runs, judgement.baselines, options, progress).cells
                                  : evaluation::judge_samples(dataset, on_runs, options, progress)));
}

std::vector<results::ReportedRun> predict_runs(const StudyPlan& plan, experiments::StepRunner& runner) {
  const StudyModel &lenet = first_model(plan, model::ModelKind::lenet), &stream = first_model(plan, model::ModelKind::stream);
  const windows::Dataset& dataset = plan.dataset(stream);
  std::vector<RunFolder> runs = evaluation::folders_of(dataset, stream.runs);
  std::vector<results::ReportedRun> reported;
  const RunFolder slips = run_with(runs, has_press_and_slip).value_or(runs.front());
  reported.push_back(predict_run(plan, lenet, slips, runner));
  reported.push_back(predict_run(plan, stream, slips, runner));
  const std::vector<RunFolder> others = evaluation::other_runs(dataset, stream.runs, stream.settings.split).runs;
  runs.insert(runs.end(), others.begin(), others.end());
  if (const auto firm = run_with(runs, has_firm_lift)) reported.push_back(predict_run(plan, stream, *firm, runner));
  return reported;
}

}  // namespace tactile::study
