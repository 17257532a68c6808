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
#include "tactile/evaluation/class_scores.hpp"
#include "tactile/evaluation/label_uncertainty.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/evaluation/whole_runs.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

/// The results of trainings on their runs, as tables over runs take them.
struct ScoredRuns {
  std::vector<RunResult*> runs;
  std::vector<results::JudgedRun> names;  ///< of each
  const results::BootstrapOptions& bootstrap;

  /// One value of each run. @param value  a member of RunResult, or a function of one
  template <class Entry, class Value>
  std::vector<Entry> each(Value value) const {
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < runs.size(); ++i) entries.push_back({names[i], std::invoke(value, *runs[i])});
    return entries;
  }

  /// One value of each run, moved out of it: for what is large and needed once.
  template <class Entry, class Value>
  std::vector<Entry> taken(Value RunResult::*value) const {
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < runs.size(); ++i) entries.push_back({names[i], std::move(runs[i]->*value)});
    return entries;
  }

  /// @param detections  those of a RunResult, or a function that gives them
  template <class Detections>
  results::DetectorScore detector(Detections detections) const {
    const auto of_runs = each<results::RunDetections>(detections);
    return {delay_table(of_runs, Touch::press, bootstrap), delay_table(of_runs, Touch::slip, bootstrap)};
  }
};

results::Confusion sum_of(std::span<const results::RunConfusion> runs) {
  results::Confusion sum;
  for (const results::RunConfusion& run : runs) sum += run.confusion;
  return sum;
}

/// Nothing where no run has a truth.
std::optional<results::TruthScore> truth_score(const ScoredRuns& scored, const results::OverTimeOptions& options) {
  ScoredRuns with_truth{{}, {}, scored.bootstrap};
  for (std::size_t i = 0; i < scored.runs.size(); ++i) {
    if (!scored.runs[i]->has_truth) continue;
    with_truth.runs.push_back(scored.runs[i]);
    with_truth.names.push_back(scored.names[i]);
  }
  if (with_truth.runs.empty()) return std::nullopt;
  const auto confusions = with_truth.each<results::RunConfusion>(&RunResult::true_confusion);
  const results::DetectorScore detector = with_truth.detector(&RunResult::true_detections);
  return results::TruthScore{
      accuracy_of(confusions, scored.bootstrap),
      sum_of(confusions),
      detector.press,
      detector.slip,
      delay_table(with_truth.each<results::RunDetections>(&RunResult::gross), Touch::slip, scored.bootstrap),
      accuracy_over_time(with_truth.taken<RunOverTime>(&RunResult::true_over_time), options, scored.bootstrap)};
}

std::vector<microseconds> guards_beside(microseconds own) {
  std::vector<microseconds> guards{own};
  for (const microseconds other : {microseconds{100'000}, microseconds{0}}) {
    if (other != own) guards.push_back(other);
  }
  return guards;
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
  evaluation.dataset = dataset.file().string();
  evaluation.manifest_hash = dataset.manifest_hash();
  evaluation.simulated = dataset.simulated();
  evaluation.sampling_guard = dataset.sampling().guard;
  evaluation.tick = first.rendering().tick;
  evaluation.confirm = text_of(options.confirmation);
  if (options.thresholds) evaluation.thresholds = text_of(*options.thresholds);
  evaluation.bootstrap = options.bootstrap;
  evaluation.engine = name_of(first.engine());
  return evaluation;
}

/// Figures of the balanced samples.
void add_sample_scores(results::Evaluation& evaluation, const ScoredRuns& scored, std::span<const microseconds> guards) {
  const results::BootstrapOptions& bootstrap = scored.bootstrap;
  evaluation.runs = scored.each<results::RunConfusion>(&RunResult::confusion);
  evaluation.accuracy = accuracy_of(evaluation.runs, bootstrap);
  evaluation.confusion = sum_of(evaluation.runs);
  evaluation.classes = class_scores_of(evaluation.runs, bootstrap);
  evaluation.calibration = calibration_of(scored.each<RunReliability>(&RunResult::reliability), bootstrap);
  evaluation.whole_run_calibration = calibration_of(scored.each<RunReliability>(&RunResult::every_tick), bootstrap);
  for (std::size_t i = 0; i < guards.size(); ++i) {
    const auto of_guard = scored.each<results::RunConfusion>([i](const RunResult& run) { return run.by_guard[i]; });
    evaluation.guards.push_back({guards[i], accuracy_of(of_guard, bootstrap),
                                 accuracy_difference(evaluation.runs, of_guard, bootstrap), sum_of(of_guard)});
  }
}

/// How much of the figures depends on where labels are.
void add_label_scores(results::Evaluation& evaluation, const ScoredRuns& scored) {
  std::vector<RunByDrawnLabels> by_draws;
  for (std::size_t i = 0; i < scored.runs.size(); ++i) {
    RunResult& run = *scored.runs[i];
    by_draws.push_back({scored.names[i], {run.confusion, run.detections}, std::move(run.by_drawn_labels)});
  }
  evaluation.label_uncertainty = label_uncertainty(by_draws, scored.bootstrap);
}

std::vector<results::BaselineScore> baselines_of(const ScoredRuns& scored) {
  std::vector<std::optional<BaselineConfusions>> confusions;
  for (const RunResult* run : scored.runs) confusions.push_back(run->baselines);
  return baseline_scores(confusions, scored.names, scored.bootstrap);
}

/// All figures. They do not depend on each other, and threads share them: drawing runs again takes most of their time.
void add_figures(results::Evaluation& evaluation, const ScoredRuns& scored, std::span<const results::Cell> cells,
                 std::span<const microseconds> guards, const EvaluationOptions& options) {
  for (const RunResult* run : scored.runs) evaluation.ticks += run->ticks, evaluation.close_ticks += run->close_ticks;
  evaluation.detections = scored.each<results::RunDetections>(&RunResult::detections);
  const unsigned threads = threads_or_all(options.threads);
  std::vector<std::function<void()>> figures{[&] { evaluation.whole_runs = whole_runs(cells, threads, scored.bootstrap); },
                                             [&] { add_label_scores(evaluation, scored); },
                                             [&] { add_sample_scores(evaluation, scored, guards); },
                                             [&] { evaluation.truth = truth_score(scored, options.over_time); },
                                             [&] { evaluation.network = scored.detector(&RunResult::detections); },
                                             [&] { evaluation.baselines = baselines_of(scored); },
                                             [&] {
                                               evaluation.over_time =
                                                   accuracy_over_time(scored.taken<RunOverTime>(&RunResult::over_time),
                                                                      options.over_time, scored.bootstrap);
                                             }};
  for (std::size_t i = 0; i < trivial_count; ++i) {
    figures.emplace_back([&scored, i, &into = evaluation.trivial[trivial_names[i]]] {
      into = scored.detector([i](const RunResult& run) { return run.trivial[i]; });
    });
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

/// One training on all of its runs.
struct JudgedTraining {
  std::vector<RunResult> runs;  ///< those with samples; their cells are in `cells`
  std::vector<results::Cell> cells;
  std::vector<results::LeftOutRun> left_out;
};

/// @param ticks  of the runs with samples
JudgedTraining judge_training(const windows::Dataset& dataset, const ModelOnRuns& training, const EvaluationOptions& options,
                              const std::vector<microseconds>& guards, std::uint64_t ticks, const ProgressCallback& progress) {
  constexpr double share_of_baselines = 0.05;
  const unsigned threads = threads_or_all(options.threads);
  const model::Classifier& classifier = *training.classifier;
  std::optional<FittedBaselines> baselines;
  const BaselineSamples samples = training_samples(dataset, classifier, threads, part_of(progress, 0, share_of_baselines));
  if (!samples.truth.empty()) baselines.emplace(samples);
  const RunScoring scoring{dataset, classifier, options, guards, decision_of(options), baselines};
  const OtherRuns others = other_runs(
      dataset, training.runs, [&](const RunFolder& run) { return model::learned_from(classifier.model(), run.events()); });
  JudgedTraining judged{std::vector<RunResult>(training.runs.size()), {}, others.left_out};
  std::vector<std::vector<results::Cell>> cells(others.runs.size());
  std::vector<std::string> why_not(others.runs.size());
  for_full_runs(
      dataset, training.runs, ticks, threads, part_of(progress, share_of_baselines, 1),
      [&](std::size_t i, const std::function<void(std::size_t)>& advance) {
        judged.runs[i] = score_run(scoring, training.runs[i], threads, advance);
      },
      others.runs.size(),
      [&](std::size_t i) {
        try {
          cells[i] = judge_other_run(scoring, others.runs[i], threads);
        } catch (const Error& error) {  // the runs with samples are judged all the same
          why_not[i] = error.what();
        }
      });
  for (std::size_t i = 0; i < why_not.size(); ++i) {
    if (!why_not[i].empty()) judged.left_out.push_back({others.runs[i].name(), why_not[i]});
  }
  for (RunResult& run : judged.runs) cells.push_back(std::move(run.cells));
  for (std::vector<results::Cell>& of_run : cells)
    judged.cells.insert(judged.cells.end(), std::make_move_iterator(of_run.begin()), std::make_move_iterator(of_run.end()));
  return judged;
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
  Evaluated evaluated{.evaluation = description_of(dataset, trainings, options), .cells = {}};
  results::Evaluation& evaluation = evaluated.evaluation;
  const std::vector<microseconds> sampling_guards = guards_beside(evaluation.sampling_guard);
  std::vector<RunResult> runs;
  ScoredRuns scored{{}, {}, options.bootstrap};
  std::vector<results::LeftOutRun> left_out;
  // A run folder that has changed is reported before other work begins.
  std::vector<std::uint64_t> ticks;
  for (const ModelOnRuns& training : trainings)
    ticks.push_back(ticks_of_unchanged(dataset, *training.classifier, training.runs, threads_or_all(options.threads)));
  for (std::size_t k = 0; k < trainings.size(); ++k) {
    const double each = 1 / static_cast<double>(trainings.size()), before = each * static_cast<double>(k);
    JudgedTraining judged =
        judge_training(dataset, trainings[k], options, sampling_guards, ticks[k], part_of(progress, before, before + each));
    for (const std::uint32_t run : trainings[k].runs)
      scored.names.push_back({dataset.runs()[run].object, dataset.runs()[run].run, k});
    std::move(judged.runs.begin(), judged.runs.end(), std::back_inserter(runs));
    left_out.insert(left_out.end(), judged.left_out.begin(), judged.left_out.end());
    for (results::Cell& cell : judged.cells) {
      cell.training = k;
      cell.setting = evaluation.models.front().name;
      evaluated.cells.push_back(std::move(cell));
    }
  }
  for (RunResult& run : runs) scored.runs.push_back(&run);
  add_figures(evaluation, scored, evaluated.cells, sampling_guards, options);
  evaluation.whole_runs.left_out = each_once(std::move(left_out));
  return evaluated;
}

Evaluated evaluate(const windows::Dataset& dataset, const model::Classifier& classifier, std::span<const std::uint32_t> test_runs,
                   const EvaluationOptions& options, const ProgressCallback& progress) {
  const ModelOnRuns one{&classifier, {test_runs.begin(), test_runs.end()}};
  return evaluate(dataset, {&one, 1}, options, progress);
}

}  // namespace tactile::evaluation
