#include "tactile/evaluation/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/version.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/model/train_model.hpp"
#include "tactile/simulation/truth.hpp"

namespace tactile {
namespace {

unsigned threads_or_all(unsigned threads) { return threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency()); }

void check_same_dataset(const Dataset& dataset, const Classifier& classifier) {
  const std::string& trained_on = classifier.model().manifest_hash;
  if (trained_on == dataset.manifest_hash()) return;
  throw Error(fmt::format(
      "{}: trained on dataset {}, but {} is {}; expected a model of this dataset, as 'tactile train' makes it",
      classifier.bundle().string(), trained_on.substr(0, 8), dataset.file().string(), dataset.manifest_hash().substr(0, 8)));
}

/// The balanced samples of one run as the network and the baselines see them.
struct RunSamples {
  std::vector<Touch> truth, said;
  std::vector<std::uint64_t> events;
  std::vector<Features> moments, fields;
};

std::vector<std::uint64_t> event_counts(const Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                        microseconds history) {
  const std::vector<Event> events = dataset.events(run);
  const auto place_of = [&events](CameraTime t) {
    return std::lower_bound(events.begin(), events.end(), t, [](const Event& event, CameraTime time) { return event.t < time; });
  };
  std::vector<std::uint64_t> counts;
  for (const std::uint32_t sample : samples) {
    const CameraTime t = dataset.samples()[sample].t;
    counts.push_back(static_cast<std::uint64_t>(place_of(t) - place_of(before(t, history))));
  }
  return counts;
}

RunSamples samples_of(const Dataset& dataset, const Classifier& classifier, std::uint32_t run, unsigned threads) {
  const auto samples = samples_of_runs(dataset, {&run, 1});
  const auto heatmaps = sample_heatmaps(dataset, classifier.rendering(), samples, threads);
  const std::size_t cells = samples.empty() ? 0 : heatmaps.size() / samples.size();
  RunSamples of_run;
  of_run.said = classifier.verdicts(heatmaps, threads);
  of_run.events = event_counts(dataset, run, samples, classifier.rendering().history);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    of_run.truth.push_back(dataset.samples()[samples[i]].touch);
    const auto heatmap = std::span(heatmaps).subspan(i * cells, cells);
    of_run.moments.push_back(moments_of(heatmap, classifier.input_size()));
    of_run.fields.push_back(shares_of_fields(heatmap, classifier.input_size()));
  }
  return of_run;
}

std::vector<BaselineScore> baseline_scores(const RunSamples& training, std::span<const RunSamples> tests,
                                           std::span<const std::string> objects, const BootstrapOptions& bootstrap) {
  const MajorityBaseline majority = fit_majority(training.truth);
  const EventCountBaseline event_count = fit_event_count(training.events, training.truth);
  const LogisticBaseline by_moments = fit_logistic(training.moments, training.truth);
  const LogisticBaseline by_fields = fit_logistic(training.fields, training.truth);
  const auto score = [&](const std::string& name, auto verdict) {
    std::vector<RunConfusion> runs;
    for (std::size_t i = 0; i < tests.size(); ++i) {
      RunConfusion run{objects[i], {}};
      for (std::size_t k = 0; k < tests[i].truth.size(); ++k) run.confusion.add(tests[i].truth[k], verdict(tests[i], k));
      runs.push_back(run);
    }
    return BaselineScore{name, accuracy_of(runs, bootstrap)};
  };
  return {score("majority", [&](const RunSamples&, std::size_t) { return majority.touch; }),
          score("event_count", [&](const RunSamples& run, std::size_t k) { return event_count.verdict(run.events[k]); }),
          score("logistic_moments", [&](const RunSamples& run, std::size_t k) { return by_moments.verdict(run.moments[k]); }),
          score("logistic_position", [&](const RunSamples& run, std::size_t k) { return by_fields.verdict(run.fields[k]); })};
}

constexpr std::size_t trivial_count = 3;
constexpr std::array<const char*, trivial_count> trivial_names{"always_press", "always_slip", "random"};

std::vector<Touch> trivial_verdicts(std::size_t detector, std::size_t count, std::uint64_t seed, const std::string& run) {
  if (detector < 2) return std::vector<Touch>(count, detector == 0 ? Touch::press : Touch::slip);
  std::vector<Touch> verdicts(count);
  Random random(seed_for(seed, {"random detector", run}));
  for (Touch& verdict : verdicts) verdict = all_touches[random.below(touch_count)];
  return verdicts;
}

/// What a run holds to detect.
struct RunTruth {
  std::vector<TouchInterval> labelled;  ///< with labels that the dataset used
  std::vector<TouchInterval> all;       ///< those in doubt too
  bool has_truth = false;
  std::vector<TouchInterval> true_ones, unlabelled;
  std::vector<std::optional<CameraTime>> gross;  ///< of each of `true_ones`
};

RunTruth truth_of(const Dataset& dataset, std::uint32_t run) {
  RunTruth truth;
  for (const DatasetInterval& interval : dataset.intervals()) {
    if (interval.run_index == run && interval.interval.touch != Touch::none) truth.labelled.push_back(interval.interval);
  }
  const DatasetRun& names = dataset.runs()[run];
  const RunFolder folder{dataset.run_folder(run), names.object, names.run};
  for (const LabelledInterval& interval : read_labels(folder.labels()).intervals) truth.all.push_back(interval.interval());
  truth.has_truth = std::filesystem::exists(folder.truth());
  if (!truth.has_truth) return truth;
  for (const TrueInterval& interval : read_truth(folder.truth()).intervals) {
    (interval.labelled ? truth.true_ones : truth.unlabelled).push_back(interval.interval);
    if (interval.labelled) truth.gross.push_back(interval.gross);
  }
  return truth;
}

/// How one detector did on one run.
struct RunScore {
  std::vector<Detection> detections;
  FalseAlarms false_alarms;
};

RunScore score_of(const FullRun& run, const RunTruth& truth, microseconds guard, const DelayOptions& options) {
  RunScore score;
  score.detections = detections_of(run.ticks, run.verdicts, truth.labelled, options);
  score.false_alarms = false_alarms_of(run.ticks, run.verdicts, truth.all, truth.unlabelled, score.detections, guard);
  return score;
}

struct FullRunScore {
  RunScore network;
  std::array<RunScore, trivial_count> trivial;
  bool has_truth = false;
  std::vector<Detection> true_ones, gross;
};

FullRunScore score_full_run(const FullRun& run, const RunTruth& truth, const std::string& name, microseconds guard,
                            const EvaluationOptions& options) {
  FullRunScore score;
  score.network = score_of(run, truth, guard, options.delay);
  for (std::size_t i = 0; i < trivial_count; ++i) {
    const FullRun trivial{run.ticks, trivial_verdicts(i, run.verdicts.size(), options.bootstrap.seed, name)};
    score.trivial[i] = score_of(trivial, truth, guard, options.delay);
  }
  score.has_truth = truth.has_truth;
  score.true_ones = detections_of(run.ticks, run.verdicts, truth.true_ones, options.delay);
  for (std::size_t i = 0; i < score.true_ones.size(); ++i) {
    if (truth.gross[i]) score.gross.push_back(counted_from(score.true_ones[i], *truth.gross[i], run.ticks));
  }
  return score;
}

template <class RunScoreOf>
DetectorScore detector_score(std::span<const FullRunScore> runs, std::span<const std::string> objects,
                             const BootstrapOptions& bootstrap, RunScoreOf run_score_of) {
  std::vector<RunDetections> detections;
  std::vector<RunFalseAlarms> alarms;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunScore& score = run_score_of(runs[i]);
    detections.push_back({objects[i], score.detections});
    alarms.push_back({objects[i], score.false_alarms});
  }
  return {delay_table(detections, Touch::press, bootstrap), delay_table(detections, Touch::slip, bootstrap),
          false_alarm_table(alarms, bootstrap)};
}

std::vector<FullRunScore> score_full_runs(const Dataset& dataset, const Classifier& classifier,
                                          std::span<const std::uint32_t> runs, microseconds guard,
                                          const EvaluationOptions& options, const ProgressCallback& progress) {
  const unsigned threads = threads_or_all(options.threads);
  std::vector<std::size_t> expected(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    check_unchanged(dataset, runs[i]);
    expected[i] = expected_ticks(dataset.run_folder(runs[i]) / "events.aedat4", classifier.rendering());
  });
  std::uint64_t total = 0, done = 0;
  for (const std::size_t ticks : expected) total += ticks;
  std::mutex guard_progress;
  std::vector<FullRunScore> scores(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    const std::string name = name_of(dataset.runs()[runs[i]]);
    const auto advance = [&](std::size_t ticks) {
      const std::scoped_lock lock(guard_progress);
      done += ticks;
      tell(progress, done, total, "every tick of " + name);
    };
    const FullRun run = classify_full_run(dataset.run_folder(runs[i]) / "events.aedat4", classifier, 1, advance);
    scores[i] = score_full_run(run, truth_of(dataset, runs[i]), name, guard, options);
  });
  return scores;
}

nlohmann::json detector_json(const DetectorScore& score) {
  return {{"delay_ms", {{"press", score.press}, {"slip", score.slip}}},
          {"false_alarms_per_min", score.false_alarms.per_min},
          {"false_alarms", score.false_alarms}};
}

nlohmann::json compared(const Figure& seen, const Figure& held_out, const Figure& difference) {
  return {{"seen", seen}, {"held_out", held_out}, {"difference", difference}};
}

}  // namespace

std::optional<bool> Evaluation::above_baselines() const {
  if (!accuracy.mean.low) return std::nullopt;
  bool above = true;
  for (const BaselineScore& baseline : baselines) {
    if (!baseline.accuracy.mean.high) return std::nullopt;
    above = above && *accuracy.mean.low > *baseline.accuracy.mean.high;
  }
  return above;
}

Evaluation evaluate(const Dataset& dataset, const Classifier& classifier, std::span<const std::uint32_t> test_runs,
                    const EvaluationOptions& options, const ProgressCallback& progress) {
  check_same_dataset(dataset, classifier);
  const unsigned threads = threads_or_all(options.threads);
  const ModelDescription& model = classifier.model();
  Evaluation evaluation;
  evaluation.model = {
      {"name", classifier.bundle().filename().string()}, {"settings", model.settings}, {"weights_sha256", model.weights_sha256}};
  evaluation.dataset = dataset.file().string();
  evaluation.manifest_hash = dataset.manifest_hash();
  evaluation.simulated = dataset.simulated();
  evaluation.guard = options.guard.value_or(dataset.sampling().guard);
  evaluation.tick = classifier.rendering().tick;
  evaluation.bootstrap = options.bootstrap;
  std::vector<std::string> objects;
  for (const std::uint32_t run : test_runs) {
    objects.push_back(dataset.runs()[run].object);
    evaluation.test_runs.push_back(name_of(dataset.runs()[run]));
  }

  // Full runs first: a run folder that has changed is told before anything else is worked on.
  const auto full = score_full_runs(dataset, classifier, test_runs, evaluation.guard, options, progress);
  const auto& bootstrap = options.bootstrap;
  evaluation.network =
      detector_score(full, objects, bootstrap, [](const FullRunScore& run) -> const RunScore& { return run.network; });
  for (std::size_t i = 0; i < trivial_count; ++i) {
    evaluation.trivial[trivial_names[i]] =
        detector_score(full, objects, bootstrap, [i](const FullRunScore& run) -> const RunScore& { return run.trivial[i]; });
  }
  if (std::any_of(full.begin(), full.end(), [](const FullRunScore& run) { return run.has_truth; })) {
    std::vector<RunDetections> true_ones, gross;
    for (std::size_t i = 0; i < full.size(); ++i) {
      true_ones.push_back({objects[i], full[i].true_ones});
      gross.push_back({objects[i], full[i].gross});
    }
    evaluation.true_press = delay_table(true_ones, Touch::press, bootstrap);
    evaluation.true_slip = delay_table(true_ones, Touch::slip, bootstrap);
    evaluation.gross_slip = delay_table(gross, Touch::slip, bootstrap);
  }

  RunSamples training;
  const Split split = split_of(dataset, model.settings.split);
  const std::size_t steps = split.train_runs.size() + test_runs.size();
  std::size_t step = 0;
  for (const std::uint32_t run : split.train_runs) {
    tell(progress, step++, steps, "training samples of " + name_of(dataset.runs()[run]));
    const RunSamples of_run = samples_of(dataset, classifier, run, threads);
    training.truth.insert(training.truth.end(), of_run.truth.begin(), of_run.truth.end());
    training.events.insert(training.events.end(), of_run.events.begin(), of_run.events.end());
    training.moments.insert(training.moments.end(), of_run.moments.begin(), of_run.moments.end());
    training.fields.insert(training.fields.end(), of_run.fields.begin(), of_run.fields.end());
  }
  std::vector<RunSamples> tests;
  std::vector<RunConfusion> confusions;
  for (const std::uint32_t run : test_runs) {
    tell(progress, step++, steps, "test samples of " + name_of(dataset.runs()[run]));
    tests.push_back(samples_of(dataset, classifier, run, threads));
    confusions.push_back({dataset.runs()[run].object, confusion_of(tests.back().truth, tests.back().said)});
    evaluation.confusion += confusions.back().confusion;
  }
  evaluation.accuracy = accuracy_of(confusions, bootstrap);
  evaluation.baselines = baseline_scores(training, tests, objects, bootstrap);
  return evaluation;
}

void to_json(nlohmann::json& json, const Evaluation& evaluation) {
  json = {{"title", title_of(evaluation)},
          {"simulated", evaluation.simulated},
          {"model", evaluation.model},
          {"dataset", {{"file", evaluation.dataset}, {"manifest_hash", evaluation.manifest_hash}}},
          {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
          {"bootstrap",
           {{"draws", evaluation.bootstrap.draws},
            {"confidence", evaluation.bootstrap.confidence},
            {"seed", evaluation.bootstrap.seed}}},
          {"guard_ms", static_cast<double>(evaluation.guard.count()) / 1000},
          {"tick_ms", static_cast<double>(evaluation.tick.count()) / 1000},
          {"classes", nlohmann::json::array()},
          {"test_runs", evaluation.test_runs},
          {"accuracy", evaluation.accuracy},
          {"confusion", evaluation.confusion}};
  for (const Touch touch : all_touches) json["classes"].push_back(name_of(touch));
  json.update(detector_json(evaluation.network));
  for (const auto& [name, score] : evaluation.trivial) json["trivial"][name] = detector_json(score);
  for (const BaselineScore& baseline : evaluation.baselines) {
    json["baselines"][baseline.name] = {{"accuracy", baseline.accuracy.mean}, {"objects", baseline.accuracy.objects}};
  }
  if (evaluation.true_press) json["delay_true_ms"] = {{"press", *evaluation.true_press}, {"slip", *evaluation.true_slip}};
  if (evaluation.gross_slip) json["delay_gross_ms"] = {{"slip", *evaluation.gross_slip}};
  const auto above = evaluation.above_baselines();
  json["above_baselines"] = above ? nlohmann::json(*above) : nlohmann::json();
}

std::string title_of(const Evaluation& evaluation) {
  return fmt::format("Evaluation of {} on {} runs", evaluation.model.at("name").get<std::string>(),
                     evaluation.simulated ? "simulated" : "real");
}

std::vector<RunConfusion> sample_confusions(const Dataset& dataset, const Classifier& classifier,
                                            std::span<const std::uint32_t> runs, unsigned threads,
                                            const ProgressCallback& progress) {
  check_same_dataset(dataset, classifier);
  std::vector<RunConfusion> confusions;
  for (const std::uint32_t run : runs) {
    tell(progress, confusions.size(), runs.size(), "test samples of " + name_of(dataset.runs()[run]));
    const auto samples = samples_of_runs(dataset, {&run, 1});
    const auto said =
        classifier.verdicts(sample_heatmaps(dataset, classifier.rendering(), samples, threads), threads_or_all(threads));
    Confusion confusion;
    for (std::size_t i = 0; i < samples.size(); ++i) confusion.add(dataset.samples()[samples[i]].touch, said[i]);
    confusions.push_back({dataset.runs()[run].object, confusion});
  }
  return confusions;
}

void to_json(nlohmann::json& json, const UnseenComparison& comparison) {
  json = {{"models", {{"seen", comparison.seen_model}, {"held_out", comparison.held_out_model}}},
          {"runs", comparison.runs},
          {"mean", compared(comparison.seen.mean, comparison.held_out.mean, comparison.difference.mean)},
          {"objects", nlohmann::json::object()}};
  for (const auto& [name, seen] : comparison.seen.objects) {
    json["objects"][name] = compared(seen, comparison.held_out.objects.at(name), comparison.difference.objects.at(name));
  }
}

UnseenComparison compare_unseen(const Dataset& dataset, const Classifier& seen, const Classifier& held_out,
                                std::span<const std::uint32_t> runs, const BootstrapOptions& options, unsigned threads,
                                const ProgressCallback& progress) {
  const auto by_seen = sample_confusions(dataset, seen, runs, threads, progress);
  const auto by_held_out = sample_confusions(dataset, held_out, runs, threads, progress);
  UnseenComparison comparison{seen.bundle().filename().string(),
                              held_out.bundle().filename().string(),
                              accuracy_of(by_seen, options),
                              accuracy_of(by_held_out, options),
                              accuracy_difference(by_seen, by_held_out, options),
                              {}};
  for (const std::uint32_t run : runs) comparison.runs.push_back(name_of(dataset.runs()[run]));
  return comparison;
}

std::vector<std::uint32_t> runs_neither_saw(const Dataset& dataset, const SplitOptions& seen, const SplitOptions& held_out) {
  const Split with = split_of(dataset, seen), without = split_of(dataset, held_out);
  std::vector<std::uint32_t> runs;
  std::set_difference(without.test_runs.begin(), without.test_runs.end(), with.train_runs.begin(), with.train_runs.end(),
                      std::back_inserter(runs));
  return runs;
}

}  // namespace tactile
