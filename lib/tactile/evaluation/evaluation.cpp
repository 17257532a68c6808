#include "tactile/evaluation/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/delay_table.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/evaluation/whole_runs.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

results::DetectorScore detector_score(std::span<const results::Cell> cells, const results::BootstrapOptions& bootstrap) {
  return {delay_table(cells, Touch::press, bootstrap), delay_table(cells, Touch::slip, bootstrap)};
}

results::EvaluatedModel description_of(const windows::Dataset& dataset, const ModelOnRuns& training) {
  const model::ModelDescription& model = training.classifier->model();
  results::EvaluatedModel evaluated{.name = training.classifier->bundle().filename().string(),
                                    .settings = model.settings,
                                    .weights_sha256 = model.weights_sha256,
                                    .test_runs = {}};
  for (const std::uint32_t run : training.runs) evaluated.test_runs.push_back(name_of(dataset.runs()[run]));
  return evaluated;
}

/// What is evaluated, and by which options; no figures yet.
results::Evaluation description_of(const windows::Dataset& dataset, std::span<const ModelOnRuns> trainings,
                                   const EvaluationOptions& options) {
  const model::Classifier& first = *trainings.front().classifier;
  results::Evaluation evaluation;
  for (const ModelOnRuns& training : trainings) evaluation.models.push_back(description_of(dataset, training));
  evaluation.dataset = {dataset.file().string(), dataset.manifest_hash()};
  evaluation.simulated = dataset.simulated();
  evaluation.sampling_guard = dataset.sampling().guard;
  evaluation.tick = first.rendering().tick;
  evaluation.onset = options.onset_visible ? "visible" : "first";
  evaluation.confirm = text_of(options.confirmation);
  if (options.thresholds) evaluation.thresholds = text_of(*options.thresholds);
  evaluation.bootstrap = options.bootstrap;
  evaluation.engine.name = name_of(first.engine());
  return evaluation;
}

/// What all trainings gave.
struct Scores {
  std::vector<results::Cell> cells;                               // of whole runs
  std::vector<results::Cell> by_labels, by_truth;                 // of runs with samples, as they were decided
  std::array<std::vector<results::Cell>, trivial_count> trivial;  // by labels
  bool has_baselines = true;                                      // of each training
  std::vector<RunReliability> samples, every_tick;
  std::uint64_t ticks = 0, close_ticks = 0;
};

void add(Scores& scores, RunResult& run, std::size_t training) {
  run.by_labels.training = training;
  const results::JudgedRun name = run.by_labels;
  const auto take = [&](std::vector<results::Cell>& list, results::Cell& cell) {
    cell.training = training;
    list.push_back(std::move(cell));
  };
  for (results::Cell& cell : run.cells) take(scores.cells, cell);
  if (run.by_truth) take(scores.by_truth, *run.by_truth);
  for (std::size_t i = 0; i < trivial_count; ++i) take(scores.trivial[i], run.trivial[i]);
  scores.samples.push_back({name, run.reliability});
  scores.every_tick.push_back({name, run.every_tick});
  scores.ticks += run.ticks;
  scores.close_ticks += run.close_ticks;
  take(scores.by_labels, run.by_labels);
}

std::map<std::string, std::vector<results::Cell>> cells_by_setting(std::span<const results::Cell> cells) {
  std::map<std::string, std::vector<results::Cell>> by_setting;
  for (const results::Cell& cell : cells) by_setting[cell.setting].push_back(cell);
  return by_setting;
}

/// All figures. They do not depend on each other, and threads share them: drawing runs again takes most of their time.
void add_figures(results::Evaluation& evaluation, const Scores& scores, const EvaluationOptions& options) {
  const results::BootstrapOptions& bootstrap = options.bootstrap;
  const unsigned threads = threads_or_all(options.threads);
  const std::map<std::string, std::vector<results::Cell>> by_setting = cells_by_setting(scores.cells);
  std::vector<std::function<void()>> figures{
      [&] { evaluation.whole_runs = whole_runs(by_setting.at(evaluation.models.front().name), threads, bootstrap); },
      [&] { evaluation.accuracy = accuracy_of(scores.by_labels, bootstrap); },
      [&] { evaluation.confusion = confusion_of(scores.by_labels); },
      [&] { evaluation.network = detector_score(scores.by_labels, bootstrap); },
      [&] { evaluation.calibration = calibration_of(scores.samples, bootstrap); },
      [&] { evaluation.whole_run_calibration = calibration_of(scores.every_tick, bootstrap); }};
  if (!scores.by_truth.empty()) {
    figures.emplace_back([&] {
      const auto [press, slip] = detector_score(scores.by_truth, bootstrap);
      evaluation.truth = {accuracy_of(scores.by_truth, bootstrap), confusion_of(scores.by_truth), {press, slip}};
    });
  }
  for (std::size_t i = 0; i < trivial_count; ++i) {
    figures.emplace_back(
        [&, i, &into = evaluation.trivial[trivial_names[i]]] { into = detector_score(scores.trivial[i], bootstrap); });
  }
  if (scores.has_baselines) {
    for (const char* name : baseline_names) {
      figures.emplace_back(
          [&, name, &into = evaluation.baselines[name]] { into = baseline_of(by_setting.at(name), threads, bootstrap); });
    }
  }
  parallel_for(figures.size(), threads, [&](std::size_t i) { figures[i](); });
}

void check_alike(std::span<const ModelOnRuns> trainings) {
  if (trainings.empty()) throw Error("no model to evaluate; expected one at least");
  const model::Classifier& first = *trainings.front().classifier;
  for (const ModelOnRuns& training : trainings) {
    if (training.classifier->rendering().tick != first.rendering().tick) {
      throw Error(fmt::format("{}: a tick of {} us; expected {} us as {} has", training.classifier->bundle().string(),
                              training.classifier->rendering().tick.count(), first.rendering().tick.count(),
                              first.bundle().string()));
    }
  }
}

/// Several trainings leave out the same runs.
std::vector<results::LeftOutRun> each_once(std::vector<results::LeftOutRun> runs) {
  const auto both = [](const results::LeftOutRun& run) { return std::tie(run.run, run.why); };
  std::sort(runs.begin(), runs.end(), [&](const auto& a, const auto& b) { return both(a) < both(b); });
  runs.erase(std::unique(runs.begin(), runs.end(), [&](const auto& a, const auto& b) { return both(a) == both(b); }), runs.end());
  return runs;
}

/// The progress of a part of the whole, from one share of it to another.
ProgressCallback part_of(const ProgressCallback& progress, double from, double to) {
  if (!progress) return {};
  return [=](const Progress& now) {
    constexpr std::uint64_t whole = 1'000'000;
    const double share = now.total > 0 ? static_cast<double>(now.done) / static_cast<double>(now.total) : 0;
    progress({static_cast<std::uint64_t>(static_cast<double>(whole) * (from + (to - from) * share)), whole, now.what});
  };
}

/// Runs with samples that no training may be judged on for another reason than that it learned from them.
void add_calibration_runs(std::vector<results::LeftOutRun>& left_out, const windows::Dataset& dataset,
                          const ModelOnRuns& training) {
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    if (std::find(training.runs.begin(), training.runs.end(), run) == training.runs.end() &&
        model::fitted_on(training.classifier->temperature(), dataset.runs()[run]))
      left_out.push_back({name_of(dataset.runs()[run]), "the model's temperature was fitted on it"});
  }
}

/// Calls `work` for each run with samples, and judges the others beside.
JudgedTraining judge_runs(const RunScoring& scoring, const ModelOnRuns& training, std::uint64_t ticks,
                          const ProgressCallback& progress,
                          const std::function<void(std::size_t, const std::function<void(std::size_t)>&)>& work) {
  const unsigned threads = threads_or_all(scoring.options.threads);
  const OtherRuns others = other_runs(scoring.dataset, training.runs, training.classifier->model());
  JudgedTraining judged{.cells = {}, .left_out = others.left_out};
  add_calibration_runs(judged.left_out, scoring.dataset, training);
  std::vector<std::vector<results::Cell>> cells(others.runs.size());
  std::vector<std::string> why_not(others.runs.size());
  for_full_runs(scoring.dataset, training.runs, ticks, threads, progress, work, others.runs.size(), [&](std::size_t i) {
    try {
      cells[i] = judge_whole_run(scoring, others.runs[i], {}, threads);
    } catch (const Error& error) {  // the runs with samples are judged all the same
      why_not[i] = error.what();
    }
  });
  for (std::size_t i = 0; i < why_not.size(); ++i) {
    if (!why_not[i].empty()) judged.left_out.push_back({others.runs[i].name(), why_not[i]});
    judged.cells.insert(judged.cells.end(), cells[i].begin(), cells[i].end());
  }
  return judged;
}

/// Adds one training on all of its runs. @param ticks  of the runs with samples
void score_training(Scores& scores, std::vector<results::LeftOutRun>& left_out, const RunScoring& scoring,
                    const ModelOnRuns& training, std::size_t number, std::uint64_t ticks, const ProgressCallback& progress) {
  const unsigned threads = threads_or_all(scoring.options.threads);
  const FittedBaselines fitted = fit_baselines(scoring.dataset, scoring.classifier, threads);
  scores.has_baselines = scores.has_baselines && fitted.baselines;
  if (!fitted.why_not.empty()) left_out.push_back({"", fitted.why_not});
  const RunScoring with_baselines{scoring.dataset, scoring.classifier, scoring.options,
                                  fitted.baselines ? &*fitted.baselines : nullptr};
  std::vector<RunResult> runs(training.runs.size());
  JudgedTraining others =
      judge_runs(with_baselines, training, ticks, progress, [&](std::size_t i, const std::function<void(std::size_t)>& advance) {
        runs[i] = score_run(with_baselines, training.runs[i], threads, advance);
      });
  for (results::Cell& cell : others.cells) {
    cell.training = number;
    scores.cells.push_back(std::move(cell));
  }
  left_out.insert(left_out.end(), others.left_out.begin(), others.left_out.end());
  for (RunResult& run : runs) add(scores, run, number);
}

}  // namespace

void leave_out_calibration_runs(std::vector<std::uint32_t>& runs, const windows::Dataset& dataset,
                                const model::Classifier& classifier) {
  std::erase_if(runs, [&](std::uint32_t run) { return model::fitted_on(classifier.temperature(), dataset.runs()[run]); });
  if (model::samples_of_runs(dataset, runs).empty()) {
    throw Error(fmt::format("{}: no run with samples is left that {} neither learned from nor was calibrated on; expected one",
                            dataset.file().string(), classifier.bundle().string()));
  }
}

Evaluated evaluate(const windows::Dataset& dataset, std::span<const ModelOnRuns> trainings, const EvaluationOptions& options,
                   const ProgressCallback& progress) {
  check_alike(trainings);
  for (const ModelOnRuns& training : trainings) check_fits(dataset, *training.classifier, options);
  // A run folder that has changed is reported before other work begins.
  std::vector<std::uint64_t> ticks;
  for (const ModelOnRuns& training : trainings)
    ticks.push_back(ticks_of_unchanged(dataset, *training.classifier, training.runs, threads_or_all(options.threads)));
  Scores scores;
  std::vector<results::LeftOutRun> left_out;
  results::Evaluation evaluation = description_of(dataset, trainings, options);
  for (std::size_t k = 0; k < trainings.size(); ++k) {
    const double each = 1 / static_cast<double>(trainings.size()), before = each * static_cast<double>(k);
    score_training(scores, left_out, {dataset, *trainings[k].classifier, options}, trainings[k], k, ticks[k],
                   part_of(progress, before, before + each));
  }
  for (results::Cell& cell : scores.cells) {
    if (cell.setting.empty()) cell.setting = evaluation.models.front().name;
  }
  evaluation.engine.ticks = scores.ticks;
  evaluation.engine.close_ticks = scores.close_ticks;
  add_figures(evaluation, scores, options);
  evaluation.whole_runs.left_out = each_once(std::move(left_out));
  return {std::move(evaluation), std::move(scores.cells)};
}

JudgedTraining judge_whole_runs(const windows::Dataset& dataset, const ModelOnRuns& training, bool with_baselines,
                                const EvaluationOptions& options, const ProgressCallback& progress) {
  check_fits(dataset, *training.classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  FittedBaselines fitted;
  if (with_baselines) fitted = fit_baselines(dataset, *training.classifier, threads);
  const RunScoring scoring{dataset, *training.classifier, options, fitted.baselines ? &*fitted.baselines : nullptr};
  std::vector<std::vector<results::Cell>> cells(training.runs.size());
  JudgedTraining judged =
      judge_runs(scoring, training, ticks_of_unchanged(dataset, *training.classifier, training.runs, threads), progress,
                 [&](std::size_t i, const std::function<void(std::size_t)>& advance) {
                   cells[i] = judge_whole_run(scoring, folder_of(dataset, training.runs[i]), training.runs[i], threads, advance);
                 });
  for (const std::vector<results::Cell>& of_run : cells) judged.cells.insert(judged.cells.end(), of_run.begin(), of_run.end());
  if (!fitted.why_not.empty()) judged.left_out.push_back({"", fitted.why_not});
  return judged;
}

Evaluated evaluate(const windows::Dataset& dataset, const model::Classifier& classifier, std::span<const std::uint32_t> test_runs,
                   const EvaluationOptions& options, const ProgressCallback& progress) {
  const ModelOnRuns one{&classifier, {test_runs.begin(), test_runs.end()}};
  return evaluate(dataset, {&one, 1}, options, progress);
}

}  // namespace tactile::evaluation
