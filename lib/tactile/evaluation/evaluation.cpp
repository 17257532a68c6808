#include "tactile/evaluation/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/class_scores.hpp"
#include "tactile/evaluation/flagged_runs.hpp"
#include "tactile/evaluation/label_uncertainty.hpp"
#include "tactile/evaluation/operating_curve.hpp"
#include "tactile/evaluation/run_result.hpp"
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

  /// @param score  a RunScore of RunResult, or a function that gives one
  template <class Score>
  results::DetectorScore detector(Score score) const {
    const auto detections =
        each<results::RunDetections>([&](const RunResult& run) { return std::invoke(score, run).detections; });
    const auto alarms = each<RunFalseAlarms>([&](const RunResult& run) { return std::invoke(score, run).false_alarms; });
    return {delay_table(detections, Touch::press, bootstrap), delay_table(detections, Touch::slip, bootstrap),
            false_alarm_table(alarms, bootstrap)};
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
  const results::DetectorScore detector = with_truth.detector(&RunResult::against_truth);
  return results::TruthScore{
      accuracy_of(confusions, scored.bootstrap),
      sum_of(confusions),
      detector.press,
      detector.slip,
      delay_table(with_truth.each<results::RunDetections>(&RunResult::gross), Touch::slip, scored.bootstrap),
      detector.false_alarms,
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
  evaluation.guard = options.guard.value_or(evaluation.sampling_guard);
  evaluation.tick = first.rendering().tick;
  evaluation.confirm = text_of(options.confirmation);
  evaluation.alarm_cost = options.alarm_cost;
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

/// A flagged run that is left out of the dataset, scored by one training.
struct ScoredFlaggedRun {
  results::JudgedRun run;
  WithFlaggedScore score;
};

/// Nothing where no run and no interval is flagged.
std::optional<results::WithFlagged> with_flagged(const ScoredRuns& scored, std::span<const ScoredFlaggedRun> left_out) {
  results::WithFlagged with;
  auto confusions = scored.each<results::RunConfusion>([](const RunResult& run) { return run.with_flagged.confusion; });
  auto detections = scored.each<results::RunDetections>([](const RunResult& run) { return run.with_flagged.detections; });
  const auto name_of_run = [](const results::JudgedRun& run) { return run.object + "/" + run.run; };
  std::set<std::string> counted, left_out_runs;  // several trainings may be judged on one run
  for (std::size_t i = 0; i < scored.runs.size(); ++i) {
    if (counted.insert(name_of_run(scored.names[i])).second) with.intervals += scored.runs[i]->with_flagged.flagged;
  }
  for (const ScoredFlaggedRun& one : left_out) {
    confusions.push_back({one.run, one.score.confusion});
    detections.push_back({one.run, one.score.detections});
    left_out_runs.insert(name_of_run(one.run));
  }
  with.runs.assign(left_out_runs.begin(), left_out_runs.end());
  if (with.runs.empty() && with.intervals == 0) return std::nullopt;
  with.accuracy = accuracy_of(confusions, scored.bootstrap).mean;
  with.press = delay_summary(detections, Touch::press, scored.bootstrap);
  with.slip = delay_summary(detections, Touch::slip, scored.bootstrap);
  return with;
}

/// How much of the figures depends on where labels are, and on which are in doubt.
void add_label_scores(results::Evaluation& evaluation, const ScoredRuns& scored, std::span<const ScoredFlaggedRun> left_out) {
  std::vector<RunByDrawnLabels> by_draws;
  for (std::size_t i = 0; i < scored.runs.size(); ++i) {
    RunResult& run = *scored.runs[i];
    by_draws.push_back({scored.names[i], {run.confusion, run.network.detections}, std::move(run.by_drawn_labels)});
  }
  evaluation.label_uncertainty = label_uncertainty(by_draws, scored.bootstrap);
  evaluation.with_flagged = with_flagged(scored, left_out);
}

results::GateOff gate_off(const ScoredRuns& scored, const model::GateRule& rule) {
  const auto open = scored.each<results::RunConfusion>(&RunResult::open_confusion);
  results::GateOff off{.limit = rule.ratio ? 0 : rule.events,
                       .ratio = rule.ratio,
                       .accuracy = accuracy_of(open, scored.bootstrap),
                       .confusion = sum_of(open),
                       .network = scored.detector(&RunResult::open)};
  for (const RunResult* run : scored.runs) off.ticks += run->ticks, off.gated += run->gated;
  return off;
}

std::vector<results::BaselineScore> baselines_of(const ScoredRuns& scored) {
  std::vector<BaselineConfusions> confusions;
  for (const RunResult* run : scored.runs) confusions.push_back(run->baselines);
  return baseline_scores(confusions, scored.names, scored.bootstrap);
}

/// All runs of the judged objects that the models did not learn from: those that are judged, the flagged ones that the dataset
/// leaves out, and those in which it has no samples.
std::size_t count_of_runs(const windows::Dataset& dataset, std::span<const ModelOnRuns> trainings,
                          const results::Evaluation& evaluation) {
  std::set<std::string> names, objects;
  for (const std::string& name : evaluation.test_runs()) names.insert(name);
  if (evaluation.with_flagged) names.insert(evaluation.with_flagged->runs.begin(), evaluation.with_flagged->runs.end());
  for (const ModelOnRuns& training : trainings) {
    for (const std::uint32_t run : training.runs) objects.insert(dataset.runs()[run].object);
  }
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    const windows::DatasetRun& one = dataset.runs()[run];
    if (objects.contains(one.object) && model::samples_of_runs(dataset, {&run, 1}).empty()) names.insert(name_of(one));
  }
  return names.size();
}

/// All figures. They do not depend on each other, and threads share them: drawing runs again takes most of their time.
void add_figures(results::Evaluation& evaluation, const ScoredRuns& scored, std::span<const microseconds> guards,
                 std::span<const ScoredFlaggedRun> left_out, const std::optional<model::GateRule>& gate,
                 const EvaluationOptions& options) {
  for (const RunResult* run : scored.runs) evaluation.ticks += run->ticks, evaluation.close_ticks += run->close_ticks;
  evaluation.detections = scored.each<results::RunDetections>([](const RunResult& run) { return run.network.detections; });
  const auto& thresholds = default_thresholds();
  evaluation.operating_curve.resize(thresholds.size());
  std::vector<std::function<void()>> figures{[&] { add_label_scores(evaluation, scored, left_out); },
                                             [&] { add_sample_scores(evaluation, scored, guards); },
                                             [&] { evaluation.truth = truth_score(scored, options.over_time); },
                                             [&] { evaluation.network = scored.detector(&RunResult::network); },
                                             [&] { evaluation.baselines = baselines_of(scored); },
                                             [&] {
                                               evaluation.over_time =
                                                   accuracy_over_time(scored.taken<RunOverTime>(&RunResult::over_time),
                                                                      options.over_time, scored.bootstrap);
                                             }};
  if (gate) figures.emplace_back([&] { evaluation.gate_off = gate_off(scored, *gate); });
  for (std::size_t i = 0; i < trivial_count; ++i) {
    figures.emplace_back([&scored, i, &into = evaluation.trivial[trivial_names[i]]] {
      into = scored.detector([i](const RunResult& run) { return run.trivial[i]; });
    });
  }
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    figures.emplace_back([&, i] {
      evaluation.operating_curve[i] = operating_point(
          thresholds[i],
          scored.each<results::RunDetections>([i](const RunResult& run) { return run.by_threshold[i].detections; }),
          scored.each<RunFalseAlarms>([i](const RunResult& run) { return run.by_threshold[i].false_alarms; }), scored.bootstrap);
    });
  }
  parallel_for(figures.size(), threads_or_all(options.threads), [&](std::size_t i) { figures[i](); });
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

/// The progress of a part of the whole, from one share of it to another.
ProgressCallback part_of(const ProgressCallback& progress, double from, double to) {
  if (!progress) return {};
  return [=](const Progress& now) {
    constexpr std::uint64_t whole = 1'000'000;
    const double share = now.total > 0 ? static_cast<double>(now.done) / static_cast<double>(now.total) : 0;
    progress({static_cast<std::uint64_t>(static_cast<double>(whole) * (from + (to - from) * share)), whole, now.what});
  };
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

results::Evaluation evaluate(const windows::Dataset& dataset, std::span<const ModelOnRuns> trainings,
                             const EvaluationOptions& options, const ProgressCallback& progress) {
  check_alike(trainings);
  for (const ModelOnRuns& training : trainings) check_fits(dataset, *training.classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  results::Evaluation evaluation = description_of(dataset, trainings, options);
  const std::vector<microseconds> sampling_guards = guards_beside(evaluation.sampling_guard);
  std::vector<RunResult> runs;
  ScoredRuns scored{{}, {}, options.bootstrap};
  std::vector<ScoredFlaggedRun> left_out;
  // A run folder that has changed is reported before other work begins.
  std::vector<std::uint64_t> ticks;
  for (const ModelOnRuns& training : trainings)
    ticks.push_back(ticks_of_unchanged(dataset, *training.classifier, training.runs, threads));
  for (std::size_t k = 0; k < trainings.size(); ++k) {
    constexpr double share_of_baselines = 0.05;
    const double each = 1 / static_cast<double>(trainings.size()), before = each * static_cast<double>(k);
    const double fitted = before + share_of_baselines * each;
    const model::Classifier& classifier = *trainings[k].classifier;
    const std::size_t first = runs.size();
    runs.resize(first + trainings[k].runs.size());
    for (const std::uint32_t run : trainings[k].runs)
      scored.names.push_back({dataset.runs()[run].object, dataset.runs()[run].run, k});
    FittedBaselines baselines(training_samples(dataset, classifier, threads, part_of(progress, before, fitted)),
                              options.bootstrap.seed);
    const RunScoring scoring{dataset,
                             classifier,
                             options,
                             evaluation.guard,
                             sampling_guards,
                             gate_of(classifier, options),
                             decision_of(classifier, options),
                             baselines};
    const std::vector<RunFolder> flagged = flagged_runs_beside(dataset, trainings[k].runs, classifier.model());
    const std::size_t first_left_out = left_out.size();
    left_out.resize(first_left_out + flagged.size());
    for_full_runs(
        dataset, trainings[k].runs, ticks[k], threads, part_of(progress, fitted, before + each),
        [&](std::size_t i, const std::function<void(std::size_t)>& advance) {
          runs[first + i] = score_run(scoring, trainings[k].runs[i], threads, advance);
        },
        FittedBaselines::parts + flagged.size(),
        [&](std::size_t part) {
          if (part < FittedBaselines::parts) return baselines.fit(part);
          const std::size_t i = part - FittedBaselines::parts;
          left_out[first_left_out + i] = {{flagged[i].object, flagged[i].run, k},
                                          score_flagged_run(scoring, flagged[i], threads)};
        });
    parallel_for(trainings[k].runs.size(), threads, [&](std::size_t i) {
      RunResult& run = runs[first + i];
      if (run.for_baselines) run.baselines = baselines.confusions_of(*std::exchange(run.for_baselines, std::nullopt));
    });
  }
  for (RunResult& run : runs) scored.runs.push_back(&run);
  add_figures(evaluation, scored, sampling_guards, left_out, gate_of(*trainings.front().classifier, options), options);
  evaluation.of_runs = count_of_runs(dataset, trainings, evaluation);
  return evaluation;
}

results::Evaluation evaluate(const windows::Dataset& dataset, const model::Classifier& classifier,
                             std::span<const std::uint32_t> test_runs, const EvaluationOptions& options,
                             const ProgressCallback& progress) {
  const ModelOnRuns one{&classifier, {test_runs.begin(), test_runs.end()}};
  return evaluate(dataset, {&one, 1}, options, progress);
}

}  // namespace tactile::evaluation
