#include "tactile/evaluation/run_result.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/operating_curve.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {
namespace {

std::vector<Touch> trivial_verdicts(std::size_t detector, std::size_t count, std::uint64_t seed, const std::string& run) {
  if (detector < 2) return std::vector<Touch>(count, detector == 0 ? Touch::press : Touch::slip);
  std::vector<Touch> verdicts(count);
  Random random(seed_for(seed, {"random detector", run}));
  for (Touch& verdict : verdicts) verdict = all_touches[random.below(touch_count)];
  return verdicts;
}

/// The samples that the dataset would have of this run by another guard; by its own, those that it has.
std::vector<windows::Sample> samples_by_guard(const windows::Dataset& dataset, std::uint32_t run, const RunTruth& truth,
                                              const TickRange& ticks, microseconds history, microseconds guard) {
  if (guard == dataset.sampling().guard) return samples_in(dataset, run);
  windows::SamplingOptions options = dataset.sampling();
  options.guard = guard;
  return samples_by(options, run, folder_of(dataset, run), truth.labels, truth, ticks, history);
}

RunScore score_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> to_detect,
                  const MotionZones& zones, const DelayOptions& options) {
  RunScore score;
  score.detections = detections_of(ticks, verdicts, to_detect, options);
  score.false_alarms = false_alarms_of(ticks, verdicts, zones, score.detections);
  return score;
}

/// A run with what the model predicts, and what is true.
struct ClassifiedRun {
  std::uint32_t index = 0;  ///< in the dataset
  std::string name;
  std::vector<windows::Sample> samples;  ///< balanced, ascending in time
  results::FullRun full{};               ///< none where the gate is closed
  std::vector<Touch> verdicts{};         ///< confirmed
  std::vector<Touch> open_verdicts{};    ///< without the gate, where it is on
  RunTruth truth{};

  std::size_t tick_of(const windows::Sample& sample) const { return place_of(sample, full.ticks, name); }
};

void score_samples(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  for (const windows::Sample& sample : run.samples) {
    const std::size_t k = run.tick_of(sample);
    result.confusion.add(sample.touch, run.verdicts[k]);
    if (scoring.gate) result.open_confusion.add(sample.touch, run.open_verdicts[k]);
    if (run.truth.has_truth) result.true_confusion.add(touch_at(sample.t, run.truth.true_ones), run.verdicts[k]);
  }
  const microseconds history = scoring.classifier.rendering().history;
  for (const microseconds guard : scoring.sampling_guards) {
    results::Confusion confusion;
    for (const windows::Sample& sample : samples_by_guard(scoring.dataset, run.index, run.truth, run.full.ticks, history, guard))
      confusion.add(sample.touch, run.verdicts[run.tick_of(sample)]);
    result.by_guard.push_back(confusion);
  }
}

void score_ticks(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  const EvaluationOptions& options = scoring.options;
  const std::vector<TouchInterval> labelled = run.truth.used(), all = run.truth.all_labelled();
  const auto score = [&](std::span<const Touch> verdicts) {
    return score_of(run.full.ticks, verdicts, labelled,
                    {all, run.truth.releases, run.truth.unlabelled, scoring.guard, run.truth.has_truth}, options.delay);
  };
  result.network = score(run.verdicts);
  if (scoring.gate) result.open = score(run.open_verdicts);
  for (std::size_t i = 0; i < trivial_count; ++i)
    result.trivial[i] = score(trivial_verdicts(i, run.verdicts.size(), options.bootstrap.seed, run.name));
  result.by_threshold.reserve(default_thresholds().size());
  for (const double threshold : default_thresholds()) {
    model::Decision decision = scoring.decision;
    const double odds = threshold / (1 - threshold);  // of a touch
    if (decision.filter) decision.filter->alarm_cost = odds;
    if (decision.thresholds) decision.thresholds = model::moved_to(*decision.thresholds, std::log(odds));
    result.by_threshold.push_back(score(model::decided(
        decision, run.full.ticks.tick, verdicts_above(run.full.probabilities, threshold), run.full.probabilities)));
  }
  std::vector<TouchInterval> elsewhere = all;
  elsewhere.insert(elsewhere.end(), run.truth.releases.begin(), run.truth.releases.end());
  elsewhere.insert(elsewhere.end(), run.truth.unlabelled.begin(), run.truth.unlabelled.end());
  result.over_time = over_time_of(run.full.ticks, run.verdicts, labelled, options.over_time, elsewhere);
}

/// Every tick of a sure class: that of its label, or none. Ticks of unclear motion and of labels in doubt have none.
Reliability reliability_of_ticks(const ClassifiedRun& run) {
  Reliability reliability;
  const std::vector<TouchInterval> used = run.truth.used();
  for (std::size_t k = 0; k < run.full.verdicts.size(); ++k) {
    const CameraTime t = run.full.ticks.at(static_cast<std::int64_t>(k));
    const Touch touch = touch_at(t, used);
    const auto holds = [t](const TouchInterval& interval) { return interval.contains(t); };
    const auto in_doubt = [t](const windows::SampledInterval& label) { return !label.used && label.interval.contains(t); };
    if (touch == Touch::none && (std::any_of(run.truth.unclear.begin(), run.truth.unclear.end(), holds) ||
                                 std::any_of(run.truth.labels.begin(), run.truth.labels.end(), in_doubt)))
      continue;
    const Touch predicted = run.full.verdicts[k];
    reliability.add(static_cast<double>(run.full.probabilities[k][static_cast<std::size_t>(predicted)]), predicted == touch);
  }
  return reliability;
}

/// The samples are those of the dataset where it has some and no label is flagged.
WithFlaggedScore score_with_flagged(const ClassifiedRun& run, const RunFolder& folder, const RunScoring& scoring) {
  WithFlaggedScore score;
  std::vector<windows::SampledInterval> all = run.truth.labels;
  for (windows::SampledInterval& label : all) {
    score.flagged += label.used ? 0 : 1;
    label.used = true;
  }
  const std::vector<windows::Sample> samples = score.flagged == 0 && !run.samples.empty()
                                                   ? run.samples
                                                   : samples_by(scoring.dataset.sampling(), run.index, folder, all, run.truth,
                                                                run.full.ticks, scoring.classifier.rendering().history);
  for (const windows::Sample& sample : samples) score.confusion.add(sample.touch, run.verdicts[run.tick_of(sample)]);
  score.detections = detections_of(run.full.ticks, run.verdicts, run.truth.all_labelled(), scoring.options.delay);
  return score;
}

void score_by_doubt(RunResult& result, const ClassifiedRun& run, const RunFolder& folder, const RunScoring& scoring) {
  std::vector<std::size_t> places;
  for (const windows::Sample& sample : run.samples) places.push_back(run.tick_of(sample));
  result.by_drawn_labels = scores_by_drawn_labels(run.full.ticks, run.verdicts, places, run.truth, scoring.options.delay,
                                                  seed_for(scoring.options.bootstrap.seed, {"labels", run.name}));
  result.with_flagged = score_with_flagged(run, folder, scoring);
}

void score_against_truth(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  const RunTruth& truth = run.truth;
  result.against_truth = score_of(run.full.ticks, run.verdicts, truth.true_ones,
                                  {truth.true_ones, {}, truth.unlabelled, scoring.guard}, scoring.options.delay);
  for (std::size_t i = 0; i < truth.true_ones.size(); ++i) {
    if (truth.gross[i]) result.gross.push_back(counted_from(result.against_truth.detections[i], *truth.gross[i], run.full.ticks));
  }
  result.true_over_time =
      over_time_of(run.full.ticks, run.verdicts, truth.true_ones, scoring.options.over_time, truth.unlabelled);
}

}  // namespace

void check_fits(const windows::Dataset& dataset, const model::Classifier& classifier, const EvaluationOptions& options) {
  const std::string& trained_on = classifier.model().manifest_hash;
  if (trained_on != dataset.manifest_hash() && !options.of_another_dataset) {
    throw Error(fmt::format(
        "{}: trained on dataset {}, but {} is {}; expected a model of this dataset, as 'tactile train' makes it",
        classifier.bundle().string(), trained_on.substr(0, 8), dataset.file().string(), dataset.manifest_hash().substr(0, 8)));
  }
  if (const events::SensorSize input = input_of(classifier.model().settings, dataset.sensor());
      input != classifier.input_size()) {
    throw Error(fmt::format("{}: takes {}; expected the {} of {}", classifier.bundle().string(),
                            input_text(classifier.kind(), classifier.input_size()), input_text(classifier.kind(), input),
                            dataset.file().string()));
  }
}

std::optional<model::GateRule> gate_of(const model::Classifier& classifier, const EvaluationOptions& options) {
  if (!options.gate) return std::nullopt;
  return model::gate_rule({classifier.bundle()}, classifier.model(), options.gate_miss);
}

model::Decision decision_of(const model::Classifier& classifier, const EvaluationOptions& options) {
  model::Decision decision{.confirmation = options.confirmation, .thresholds = options.thresholds};
  if (options.alarm_cost) decision.filter = model::filter_of({classifier.bundle()}, classifier.model(), *options.alarm_cost);
  return decision;
}

RunFolder folder_of(const windows::Dataset& dataset, std::uint32_t run) {
  const windows::DatasetRun& names = dataset.runs()[run];
  return {dataset.run_folder(run), names.object, names.run};
}

std::vector<windows::Sample> samples_in(const windows::Dataset& dataset, std::uint32_t run) {
  std::vector<windows::Sample> samples;
  for (const std::uint32_t index : model::samples_of_runs(dataset, {&run, 1})) samples.push_back(dataset.samples()[index]);
  return samples;
}

std::vector<windows::Sample> samples_by(const windows::SamplingOptions& options, std::uint32_t run, const RunFolder& folder,
                                        std::span<const windows::SampledInterval> labels, const RunTruth& truth,
                                        const TickRange& ticks, microseconds history) {
  if (ticks.count == 0) return {};
  return windows::balanced_samples(run, labels, before(ticks.first, history), ticks.at(ticks.count - 1),
                                   seed_for(options.seed, {"windows", folder.object, folder.run}), options, truth.unclear);
}

std::size_t place_of(const windows::Sample& sample, const TickRange& ticks, const std::string& run) {
  const microseconds since = between(ticks.first, sample.t);
  if (since < microseconds{0} || since % ticks.tick != microseconds{0} || since / ticks.tick >= ticks.count) {
    throw Error(
        fmt::format("{}: its sample at {} us is at no tick of the model, every {} us from {} us; expected a dataset and "
                    "a model with the same tick",
                    run, us_of(sample.t), ticks.tick.count(), us_of(ticks.first)));
  }
  return static_cast<std::size_t>(since / ticks.tick);
}

RunResult score_run(const RunScoring& scoring, std::uint32_t run_index, unsigned threads,
                    const std::function<void(std::size_t)>& advance) {
  const windows::Dataset& dataset = scoring.dataset;
  const RunFolder folder = folder_of(dataset, run_index);
  ClassifiedRun run{.index = run_index, .name = name_of(dataset.runs()[run_index]), .samples = samples_in(dataset, run_index)};
  RunResult result;
  BaselineSamples samples;
  std::size_t next = 0;
  const auto see = [&](CameraTime tick, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
    if (next == run.samples.size() || tick != run.samples[next].t) return;
    samples.add(run.samples[next].touch, events, heatmap, scoring.classifier.input_size());
    ++next;
  };
  run.full = classify_full_run(folder.events(), scoring.classifier,
                               {.threads = threads, .advance = advance, .see = see, .ratios = needs_ratios(scoring.gate)});
  if (reads_heatmaps(scoring.classifier.kind())) {
    add_features(samples, dataset, scoring.classifier, run_index);
  } else {
    samples = samples_of(dataset, scoring.classifier, run_index, threads);
  }
  if (scoring.baselines.are_fitted()) {
    result.baselines = scoring.baselines.confusions_of(samples);
  } else {
    result.for_baselines = std::move(samples);
  }
  for (const windows::Sample& sample : run.samples) {
    const std::size_t k = run.tick_of(sample);
    const Touch predicted = run.full.verdicts[k];
    result.reliability.add(static_cast<double>(run.full.probabilities[k][static_cast<std::size_t>(predicted)]),
                           predicted == sample.touch);
  }
  run.truth = read_run_truth(folder, member<bool>(dataset.settings(), "include_flagged", dataset.file().string()));
  result.every_tick = reliability_of_ticks(run);
  if (scoring.gate) {
    run.open_verdicts = decided(scoring.decision, run.full);
    result.gated = apply_gate(run.full, *scoring.gate);
  }
  run.verdicts = decided(scoring.decision, run.full);
  result.ticks = run.verdicts.size();
  result.close_ticks = run.full.close;
  result.has_truth = run.truth.has_truth;
  score_samples(result, run, scoring);
  score_ticks(result, run, scoring);
  score_by_doubt(result, run, folder, scoring);
  if (run.truth.has_truth) score_against_truth(result, run, scoring);
  return result;
}

WithFlaggedScore score_flagged_run(const RunScoring& scoring, const RunFolder& folder, unsigned threads) {
  ClassifiedRun run{.index = 0, .name = folder.name(), .samples = {}};
  run.full = classify_full_run(folder.events(), scoring.classifier, {.threads = threads, .ratios = needs_ratios(scoring.gate)});
  if (scoring.gate) apply_gate(run.full, *scoring.gate);
  run.verdicts = decided(scoring.decision, run.full);
  run.truth = read_run_truth(folder, true);
  return score_with_flagged(run, folder, scoring);
}

std::uint64_t ticks_of_unchanged(const windows::Dataset& dataset, const model::Classifier& classifier,
                                 std::span<const std::uint32_t> runs, unsigned threads) {
  std::vector<std::size_t> expected(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    windows::check_unchanged(dataset, runs[i]);
    expected[i] = expected_ticks(folder_of(dataset, runs[i]).events(), classifier.rendering());
  });
  return std::accumulate(expected.begin(), expected.end(), std::uint64_t{0});
}

void for_full_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, std::uint64_t total, unsigned threads,
                   const ProgressCallback& progress,
                   const std::function<void(std::size_t, const std::function<void(std::size_t)>&)>& work, std::size_t others,
                   const std::function<void(std::size_t)>& other_work) {
  std::uint64_t done = 0;
  std::mutex guard_progress;
  parallel_for(others + runs.size(), threads, [&](std::size_t item) {
    if (item < others) return other_work(item);
    const std::size_t i = item - others;
    const auto advance = [&](std::size_t ticks) {
      const std::scoped_lock lock(guard_progress);
      done += ticks;
      report_progress(progress, done, total, "every tick of " + name_of(dataset.runs()[runs[i]]));
    };
    work(i, advance);
  });
}

}  // namespace tactile::evaluation
