#include "tactile/evaluation/evaluation.hpp"

#include <algorithm>
#include <functional>

#include "tactile/core/parallel.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/class_scores.hpp"
#include "tactile/evaluation/operating_curve.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

/// Runs with their objects, as tables over runs take them.
struct ScoredRuns {
  std::vector<RunResult> runs;
  std::vector<std::string> objects;  ///< of each run
  const results::BootstrapOptions& bootstrap;

  /// One value of each run. @param value  a member of RunResult, or a function of one
  template <class Entry, class Value>
  std::vector<Entry> each(Value value) const {
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < runs.size(); ++i) entries.push_back({objects[i], std::invoke(value, runs[i])});
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
    if (!scored.runs[i].has_truth) continue;
    with_truth.runs.push_back(scored.runs[i]);
    with_truth.objects.push_back(scored.objects[i]);
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
      accuracy_over_time(with_truth.each<RunOverTime>(&RunResult::true_over_time), options, scored.bootstrap)};
}

std::vector<microseconds> guards_beside(microseconds own) {
  std::vector<microseconds> guards{own};
  for (const microseconds other : {microseconds{100'000}, microseconds{0}}) {
    if (other != own) guards.push_back(other);
  }
  return guards;
}

/// What is evaluated, and by which options; no figures yet.
results::Evaluation description_of(const windows::Dataset& dataset, const model::Classifier& classifier,
                                   std::span<const std::uint32_t> test_runs, const EvaluationOptions& options) {
  const model::ModelDescription& model = classifier.model();
  results::Evaluation evaluation;
  evaluation.model = {
      {"name", classifier.bundle().filename().string()}, {"settings", model.settings}, {"weights_sha256", model.weights_sha256}};
  evaluation.dataset = dataset.file().string();
  evaluation.manifest_hash = dataset.manifest_hash();
  evaluation.simulated = dataset.simulated();
  evaluation.sampling_guard = dataset.sampling().guard;
  evaluation.guard = options.guard.value_or(evaluation.sampling_guard);
  evaluation.tick = classifier.rendering().tick;
  evaluation.confirm = text_of(options.confirmation);
  evaluation.bootstrap = options.bootstrap;
  evaluation.engine = name_of(classifier.engine());
  for (const std::uint32_t run : test_runs) evaluation.test_runs.push_back(name_of(dataset.runs()[run]));
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
  for (std::size_t i = 0; i < guards.size(); ++i) {
    const auto of_guard = scored.each<results::RunConfusion>([i](const RunResult& run) { return run.by_guard[i]; });
    evaluation.guards.push_back({guards[i], accuracy_of(of_guard, bootstrap),
                                 accuracy_difference(evaluation.runs, of_guard, bootstrap), sum_of(of_guard)});
  }
}

/// Figures of every tick, of the network and of trivial detectors.
void add_tick_scores(results::Evaluation& evaluation, const ScoredRuns& scored, const results::OverTimeOptions& options) {
  for (const RunResult& run : scored.runs) evaluation.ticks += run.ticks, evaluation.close_ticks += run.close_ticks;
  evaluation.detections = scored.each<results::RunDetections>([](const RunResult& run) { return run.network.detections; });
  evaluation.network = scored.detector(&RunResult::network);
  for (std::size_t i = 0; i < trivial_count; ++i)
    evaluation.trivial[trivial_names[i]] = scored.detector([i](const RunResult& run) { return run.trivial[i]; });
  for (std::size_t i = 0; i < default_thresholds().size(); ++i) {
    evaluation.operating_curve.push_back(operating_point(
        default_thresholds()[i],
        scored.each<results::RunDetections>([i](const RunResult& run) { return run.by_threshold[i].detections; }),
        scored.each<RunFalseAlarms>([i](const RunResult& run) { return run.by_threshold[i].false_alarms; }), scored.bootstrap));
  }
  evaluation.over_time = accuracy_over_time(scored.each<RunOverTime>(&RunResult::over_time), options, scored.bootstrap);
}

results::GateOff gate_off(const ScoredRuns& scored, std::uint64_t limit) {
  const auto open = scored.each<results::RunConfusion>(&RunResult::open_confusion);
  results::GateOff off{.limit = limit,
                       .accuracy = accuracy_of(open, scored.bootstrap),
                       .confusion = sum_of(open),
                       .network = scored.detector(&RunResult::open)};
  for (const RunResult& run : scored.runs) off.ticks += run.ticks, off.gated += run.gated;
  return off;
}

}  // namespace

results::Evaluation evaluate(const windows::Dataset& dataset, const model::Classifier& classifier,
                             std::span<const std::uint32_t> test_runs, const EvaluationOptions& options,
                             const ProgressCallback& progress) {
  check_fits(dataset, classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  results::Evaluation evaluation = description_of(dataset, classifier, test_runs, options);
  ScoredRuns scored{std::vector<RunResult>(test_runs.size()), {}, options.bootstrap};
  for (const std::uint32_t run : test_runs) scored.objects.push_back(dataset.runs()[run].object);

  // Full runs first: a run folder that has changed is reported before other work begins.
  const RunScoring scoring{
      dataset, classifier, options, evaluation.guard, guards_beside(evaluation.sampling_guard), gate_of(classifier, options)};
  for_full_runs(dataset, classifier, test_runs, threads, progress,
                [&](std::size_t i, unsigned threads_each, const std::function<void(std::size_t)>& advance) {
                  scored.runs[i] = score_run(scoring, test_runs[i], threads_each, advance);
                });
  add_sample_scores(evaluation, scored, scoring.sampling_guards);
  add_tick_scores(evaluation, scored, options.over_time);
  if (scoring.gate) evaluation.gate_off = gate_off(scored, *scoring.gate);
  evaluation.truth = truth_score(scored, options.over_time);

  std::vector<BaselineSamples> tests;
  for (RunResult& run : scored.runs) tests.push_back(std::move(run.samples));
  evaluation.baselines =
      baseline_scores(training_samples(dataset, classifier, threads, progress), tests, scored.objects, options.bootstrap);
  return evaluation;
}

}  // namespace tactile::evaluation
