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
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
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

/// A run with what the model predicts, and what is true.
struct ClassifiedRun {
  RunFolder folder;
  std::vector<windows::Sample> samples{};  ///< balanced, ascending in time; none of a run that the dataset has none of
  results::FullRun full{};
  std::vector<Touch> verdicts{};  ///< as decided
  RunTruth truth{};

  std::size_t tick_of(const windows::Sample& sample) const { return place_of(sample, full.ticks, folder.name()); }
};

/// A cell with the run's name and the confusion of verdicts. @param intervals  give samples the class of their tick; null: their
/// own
void complete(results::Cell& cell, const ClassifiedRun& run, std::span<const Touch> verdicts,
              const std::vector<TouchInterval>* intervals = nullptr) {
  cell.world = run.truth.world;
  cell.object = run.folder.object;
  cell.run = run.folder.run;
  for (const windows::Sample& sample : run.samples)
    cell.samples.add(intervals == nullptr ? sample.touch : touch_at(sample.t, *intervals), verdicts[run.tick_of(sample)]);
}

/// Cells along the curve, with the run's name; the first, which is as decided, has the samples.
void add_cells(std::vector<results::Cell>& all, const ClassifiedRun& run, std::vector<results::Cell> cells,
               std::span<const Touch> verdicts, const std::string& setting) {
  complete(cells.front(), run, verdicts);
  for (results::Cell& cell : cells) {
    cell.world = cells.front().world, cell.object = cells.front().object, cell.run = cells.front().run;
    cell.setting = setting;
    all.push_back(cell);
  }
}

std::vector<results::Cell> cells_of(const ClassifiedRun& run, const RunScoring& scoring) {
  const EvaluationOptions& options = scoring.options;
  const TickRange& ticks = run.full.ticks;
  const Course course = course_of(run.truth);
  const RunJudge judge(ticks, course, options.delay);
  std::vector<results::Cell> cells;
  add_cells(cells, run, judged_along_curve(judge, ticks.tick, run.verdicts, run.full.probabilities, options.thresholds),
            run.verdicts, "");
  if (scoring.baselines == nullptr) return cells;
  const std::vector<TickEvents> events = events_of_ticks(run.folder.events(), ticks, scoring.classifier.rendering().mask);
  const std::vector<Touch> classes = nearest_classes(course, ticks);
  for (std::size_t baseline = 0; baseline < baseline_names.size(); ++baseline) {
    const std::vector<model::Probabilities> predicted = scoring.baselines->predict(baseline, events, classes);
    const std::vector<Touch> verdicts =
        model::decided({.thresholds = model::TwoThresholds{}}, ticks.tick, std::vector<Touch>(predicted.size()), predicted);
    add_cells(cells, run, judged_along_curve(judge, ticks.tick, verdicts, predicted), verdicts, baseline_names[baseline]);
  }
  return cells;
}

/// By the labels that are in use.
void score_by_labels(RunResult& result, const ClassifiedRun& run, const EvaluationOptions& options) {
  const RunJudge judge(run.full.ticks, course_by_labels(run.truth), options.delay);
  result.by_labels = judge.judged(run.verdicts);
  complete(result.by_labels, run, run.verdicts);
  for (std::size_t i = 0; i < trivial_count; ++i) {
    result.trivial[i] = judge.judged(trivial_verdicts(i, run.verdicts.size(), options.bootstrap.seed, run.folder.name()));
    result.trivial[i].world = run.truth.world;
    result.trivial[i].object = run.folder.object;
    result.trivial[i].run = run.folder.run;
  }
}

/// The class of each tick by the labels: none in unclear motion and where labels are in doubt.
std::vector<std::optional<Touch>> sure_classes(const RunTruth& truth, const TickRange& ticks) {
  const std::vector<TouchInterval> used = truth.used();
  std::vector<std::optional<Touch>> classes;
  for (std::int64_t k = 0; k < ticks.count; ++k) {
    const CameraTime t = ticks.at(k);
    const Touch touch = touch_at(t, used);
    const auto holds = [t](const TouchInterval& interval) { return interval.contains(t); };
    const auto in_doubt = [t](const windows::SampledInterval& label) { return !label.used && label.interval.contains(t); };
    const bool is_unclear = touch == Touch::none && (std::any_of(truth.unclear.begin(), truth.unclear.end(), holds) ||
                                                     std::any_of(truth.labels.begin(), truth.labels.end(), in_doubt));
    classes.push_back(is_unclear ? std::nullopt : std::optional(touch));
  }
  return classes;
}

LearnedRun learned_run(const windows::Dataset& dataset, std::uint32_t run, const heatmaps::HeatmapOptions& rendering) {
  windows::check_unchanged(dataset, run);
  const RunFolder folder = folder_of(dataset, run);
  const events::RecordingReader reader(folder.events());
  const TickRange ticks = heatmaps::listed_ticks(reader, events::event_stream(reader).id, rendering);
  return {events_of_ticks(folder.events(), ticks, rendering.mask),
          sure_classes(read_run_truth(folder, includes_flagged(dataset)), ticks)};
}

Reliability reliability_of_ticks(const ClassifiedRun& run) {
  Reliability reliability;
  const std::vector<std::optional<Touch>> classes = sure_classes(run.truth, run.full.ticks);
  for (std::size_t k = 0; k < classes.size(); ++k) {
    const Touch predicted = run.full.verdicts[k];
    if (classes[k])
      reliability.add(static_cast<double>(run.full.probabilities[k][static_cast<std::size_t>(predicted)]),
                      predicted == *classes[k]);
  }
  return reliability;
}

ClassifiedRun classified(const RunScoring& scoring, const RunFolder& folder, std::optional<std::uint32_t> index,
                         const FullRunOptions& options) {
  ClassifiedRun run{.folder = folder};
  if (index) run.samples = samples_in(scoring.dataset, *index);
  run.full = classify_full_run(folder.events(), scoring.classifier, options);
  run.truth = read_run_truth(folder, includes_flagged(scoring.dataset));
  if (scoring.options.onset_visible) run.truth = with_visible_onsets(std::move(run.truth));
  run.verdicts = decided(decision_of(scoring.options), run.full);
  return run;
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

FittedBaselines fit_baselines(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads) {
  std::vector<std::uint32_t> learned;
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    if (model::learned_from(classifier.model(), dataset.runs()[run])) learned.push_back(run);
  }
  std::vector<LearnedRun> runs(learned.size());
  try {
    parallel_for(learned.size(), threads,
                 [&](std::size_t i) { runs[i] = learned_run(dataset, learned[i], classifier.rendering()); });
  } catch (const Error& error) {  // the model is judged all the same
    return {.baselines = {}, .why_not = fmt::format("Published detectors are not judged: {}", error.what())};
  }
  const auto has = [&](bool touch) {
    return std::any_of(runs.begin(), runs.end(), [&](const LearnedRun& run) {
      return std::any_of(run.truth.begin(), run.truth.end(),
                         [&](const std::optional<Touch>& one) { return one && (*one != Touch::none) == touch; });
    });
  };
  if (!has(true) || !has(false)) return {};
  return {.baselines = Baselines(runs, classifier.rendering().tick), .why_not = {}};
}

RunResult score_run(const RunScoring& scoring, std::uint32_t run_index, unsigned threads,
                    const std::function<void(std::size_t)>& advance) {
  const ClassifiedRun run =
      classified(scoring, folder_of(scoring.dataset, run_index), run_index, {.threads = threads, .advance = advance});
  RunResult result;
  for (const windows::Sample& sample : run.samples) {
    const std::size_t k = run.tick_of(sample);
    const Touch predicted = run.full.verdicts[k];
    result.reliability.add(static_cast<double>(run.full.probabilities[k][static_cast<std::size_t>(predicted)]),
                           predicted == sample.touch);
  }
  result.every_tick = reliability_of_ticks(run);
  result.ticks = run.verdicts.size();
  result.close_ticks = run.full.close;
  result.cells = cells_of(run, scoring);
  score_by_labels(result, run, scoring.options);
  if (run.truth.has_truth) {
    result.by_truth = result.cells.front();
    result.by_truth->samples = {};
    complete(*result.by_truth, run, run.verdicts, &run.truth.true_ones);
  }
  return result;
}

std::vector<results::Cell> judge_whole_run(const RunScoring& scoring, const RunFolder& folder, std::optional<std::uint32_t> index,
                                           unsigned threads, const std::function<void(std::size_t)>& advance) {
  return cells_of(classified(scoring, folder, index, {.threads = threads, .advance = advance}), scoring);
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
