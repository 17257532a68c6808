#include "tactile/evaluation/run_result.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/other_runs.hpp"
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

/// A run with what the model predicts, and what is true.
struct ClassifiedRun {
  std::uint32_t index = 0;  ///< in the dataset
  std::string name;
  std::vector<windows::Sample> samples;  ///< balanced, ascending in time
  results::FullRun full{};
  std::vector<Touch> verdicts{};  ///< as decided
  RunTruth truth{};

  std::size_t tick_of(const windows::Sample& sample) const { return place_of(sample, full.ticks, name); }
};

void score_samples(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  for (const windows::Sample& sample : run.samples) {
    const std::size_t k = run.tick_of(sample);
    result.confusion.add(sample.touch, run.verdicts[k]);
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
  const std::vector<TouchInterval> labelled = run.truth.used();
  result.detections = detections_of(run.full.ticks, run.verdicts, labelled, options.delay);
  for (std::size_t i = 0; i < trivial_count; ++i)
    result.trivial[i] = detections_of(run.full.ticks, trivial_verdicts(i, run.verdicts.size(), options.bootstrap.seed, run.name),
                                      labelled, options.delay);
  std::vector<TouchInterval> elsewhere = run.truth.all_labelled();
  elsewhere.insert(elsewhere.end(), run.truth.releases.begin(), run.truth.releases.end());
  elsewhere.insert(elsewhere.end(), run.truth.unlabelled.begin(), run.truth.unlabelled.end());
  result.over_time = over_time_of(run.full.ticks, run.verdicts, labelled, options.over_time, elsewhere);
}

/// Named by the run; world and training stay empty.
std::vector<results::Cell> cells_of(const ClassifiedRun& run, const RunFolder& folder, const RunScoring& scoring) {
  const RunJudge judge(run.full.ticks, course_of(run.truth), scoring.options.delay);
  std::vector<results::Cell> cells = judged_along_curve(judge, run.full.ticks.tick, run.verdicts, run.full.probabilities,
                                                        scoring.options.thresholds.value_or(model::TwoThresholds{}));
  for (results::Cell& cell : cells) {
    cell.world = run.truth.world;
    cell.object = folder.object;
    cell.run = folder.run;
  }
  for (const windows::Sample& sample : run.samples) cells.front().samples.add(sample.touch, run.verdicts[run.tick_of(sample)]);
  return cells;
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

void score_by_doubt(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  std::vector<std::size_t> places;
  for (const windows::Sample& sample : run.samples) places.push_back(run.tick_of(sample));
  result.by_drawn_labels = scores_by_drawn_labels(run.full.ticks, run.verdicts, places, run.truth, scoring.options.delay,
                                                  seed_for(scoring.options.bootstrap.seed, {"labels", run.name}));
}

void score_against_truth(RunResult& result, const ClassifiedRun& run, const RunScoring& scoring) {
  const RunTruth& truth = run.truth;
  result.true_detections = detections_of(run.full.ticks, run.verdicts, truth.true_ones, scoring.options.delay);
  for (std::size_t i = 0; i < truth.true_ones.size(); ++i) {
    if (truth.gross[i]) result.gross.push_back(counted_from(result.true_detections[i], *truth.gross[i], run.full.ticks));
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

model::Decision decision_of(const EvaluationOptions& options) {
  return {.confirmation = options.confirmation, .thresholds = options.thresholds};
}

RunFolder folder_of(const windows::Dataset& dataset, std::uint32_t run) {
  const windows::DatasetRun& names = dataset.runs()[run];
  return {dataset.run_folder(run), names.object, names.run};
}

std::vector<RunFolder> folders_of(const windows::Dataset& dataset, std::span<const std::uint32_t> runs) {
  std::vector<RunFolder> folders;
  for (const std::uint32_t run : runs) folders.push_back(folder_of(dataset, run));
  return folders;
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
  run.full = classify_full_run(folder.events(), scoring.classifier, {.threads = threads, .advance = advance, .see = see});
  if (scoring.baselines) {
    if (!reads_heatmaps(scoring.classifier.kind())) samples = samples_of(dataset, scoring.classifier, run_index, threads);
    result.baselines = scoring.baselines->confusions_of(samples);
  }
  for (const windows::Sample& sample : run.samples) {
    const std::size_t k = run.tick_of(sample);
    const Touch predicted = run.full.verdicts[k];
    result.reliability.add(static_cast<double>(run.full.probabilities[k][static_cast<std::size_t>(predicted)]),
                           predicted == sample.touch);
  }
  run.truth = read_run_truth(folder, includes_flagged(dataset));
  result.every_tick = reliability_of_ticks(run);
  run.verdicts = decided(scoring.decision, run.full);
  result.ticks = run.verdicts.size();
  result.close_ticks = run.full.close;
  result.has_truth = run.truth.has_truth;
  result.cells = cells_of(run, folder, scoring);
  score_samples(result, run, scoring);
  score_ticks(result, run, scoring);
  score_by_doubt(result, run, scoring);
  if (run.truth.has_truth) score_against_truth(result, run, scoring);
  return result;
}

std::vector<results::Cell> judge_other_run(const RunScoring& scoring, const RunFolder& folder, unsigned threads) {
  ClassifiedRun run{.index = 0, .name = folder.name(), .samples = {}};
  run.full = classify_full_run(folder.events(), scoring.classifier, {.threads = threads});
  run.verdicts = decided(scoring.decision, run.full);
  run.truth = read_run_truth(folder, includes_flagged(scoring.dataset));
  return cells_of(run, folder, scoring);
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
