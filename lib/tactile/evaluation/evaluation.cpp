#include "tactile/evaluation/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/event_counts.hpp"

namespace tactile {
namespace {

unsigned threads_or_all(unsigned threads) { return threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency()); }

void check_fits(const Dataset& dataset, const Classifier& classifier, const EvaluationOptions& options) {
  const std::string& trained_on = classifier.model().manifest_hash;
  if (trained_on != dataset.manifest_hash() && !options.of_another_dataset) {
    throw Error(fmt::format(
        "{}: trained on dataset {}, but {} is {}; expected a model of this dataset, as 'tactile train' makes it",
        classifier.bundle().string(), trained_on.substr(0, 8), dataset.file().string(), dataset.manifest_hash().substr(0, 8)));
  }
  if (const SensorSize size = heatmap_size(dataset.sensor(), classifier.rendering().factor); size != classifier.input_size()) {
    throw Error(fmt::format("{}: takes heatmaps of {} x {}; expected the {} x {} of {}", classifier.bundle().string(),
                            classifier.input_size().width, classifier.input_size().height, size.width, size.height,
                            dataset.file().string()));
  }
}

/// The dataset's runs that the model learned from first hand, which the baselines are fitted on.
std::vector<std::uint32_t> training_runs_of(const Dataset& dataset, const ModelDescription& model) {
  if (model.manifest_hash == dataset.manifest_hash()) return split_of(dataset, model.settings.split).train_runs;
  std::vector<std::uint32_t> runs;
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    const auto& named = model.train_runs;
    if (learned_from(model, dataset.runs()[run].events_sha256) &&
        std::find(named.begin(), named.end(), name_of(dataset.runs()[run])) != named.end())
      runs.push_back(run);
  }
  return runs;
}

/// The limit of the model's gate, where it is to be used.
std::optional<std::uint64_t> gate_of(const Classifier& classifier, const EvaluationOptions& options) {
  if (!options.gate) return std::nullopt;
  return gate_limit({classifier.bundle()}, classifier.model());
}

/// The balanced samples of one run as the baselines see them.
struct RunSamples {
  std::vector<Touch> truth;
  std::vector<std::uint64_t> events;
  std::vector<Features> moments, fields;

  void add(Touch touch, std::uint64_t events_in_window, std::span<const std::uint8_t> heatmap, SensorSize size) {
    truth.push_back(touch);
    events.push_back(events_in_window);
    moments.push_back(moments_of(heatmap, size));
    fields.push_back(shares_of_fields(heatmap, size));
  }
};

void add_samples(RunSamples& samples, const Dataset& dataset, const Classifier& classifier, std::uint32_t run, unsigned threads) {
  const auto indexes = samples_of_runs(dataset, {&run, 1});
  const auto heatmaps = sample_heatmaps(dataset, classifier.rendering(), indexes, threads);
  const auto events = event_counts(dataset, run, indexes, classifier.rendering().history);
  const std::size_t cells = indexes.empty() ? 0 : heatmaps.size() / indexes.size();
  for (std::size_t i = 0; i < indexes.size(); ++i) {
    samples.add(dataset.samples()[indexes[i]].touch, events[i], std::span(heatmaps).subspan(i * cells, cells),
                classifier.input_size());
  }
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

RunFolder folder_of(const Dataset& dataset, std::uint32_t run) {
  const DatasetRun& names = dataset.runs()[run];
  return {dataset.run_folder(run), names.object, names.run};
}

/// The dataset's samples of a run, ascending in time.
std::vector<Sample> samples_in(const Dataset& dataset, std::uint32_t run) {
  std::vector<Sample> samples;
  for (const std::uint32_t index : samples_of_runs(dataset, {&run, 1})) samples.push_back(dataset.samples()[index]);
  return samples;
}

/// The samples that the dataset would have of this run by another guard; by its own, those that it has.
std::vector<Sample> samples_by_guard(const Dataset& dataset, std::uint32_t run, const RunTruth& truth, const TickRange& ticks,
                                     microseconds history, microseconds guard) {
  if (guard == dataset.sampling().guard) return samples_in(dataset, run);
  if (ticks.count == 0) return {};
  SamplingOptions options = dataset.sampling();
  options.guard = guard;
  const DatasetRun& names = dataset.runs()[run];
  return balanced_samples(run, truth.labels, before(ticks.first, history), ticks.at(ticks.count - 1),
                          seed_for(options.seed, {"windows", names.object, names.run}), options);
}

/// The place of a sample's tick in a full run.
std::size_t place_of(const Sample& sample, const TickRange& ticks, const std::string& run) {
  const microseconds since = between(ticks.first, sample.t);
  if (since < microseconds{0} || since % ticks.tick != microseconds{0} || since / ticks.tick >= ticks.count) {
    throw Error(
        fmt::format("{}: its sample at {} us lies at no tick of the model's, {} us apart from {} us on; expected a dataset "
                    "and a model of one tick",
                    run, us_of(sample.t), ticks.tick.count(), us_of(ticks.first)));
  }
  return static_cast<std::size_t>(since / ticks.tick);
}

/// How one detector did on one run.
struct RunScore {
  std::vector<Detection> detections;
  FalseAlarms false_alarms;
};

RunScore score_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> to_detect,
                  std::span<const TouchInterval> all, std::span<const TouchInterval> unlabelled, microseconds guard,
                  const DelayOptions& options) {
  RunScore score;
  score.detections = detections_of(ticks, verdicts, to_detect, options);
  score.false_alarms = false_alarms_of(ticks, verdicts, all, unlabelled, score.detections, guard);
  return score;
}

/// All that is kept of a run.
struct RunResult {
  std::size_t ticks = 0, close_ticks = 0;
  Confusion confusion;
  Reliability reliability;
  std::vector<Confusion> by_guard;
  RunSamples samples;
  RunScore network;
  std::array<RunScore, trivial_count> trivial;
  std::vector<RunScore> by_threshold;
  OverTimeOfRun over_time;
  bool has_truth = false;
  Confusion true_confusion;
  RunScore against_truth;
  std::vector<Detection> gross;
  OverTimeOfRun true_over_time;
  std::uint64_t gated = 0;
  Confusion open_confusion;  ///< without the gate, as is the next
  RunScore open;
};

/// What every run is scored by.
struct Scoring {
  const Dataset& dataset;
  const Classifier& classifier;
  const EvaluationOptions& options;
  microseconds guard;                         ///< of false alarms
  std::vector<microseconds> sampling_guards;  ///< the dataset's own first
  std::optional<std::uint64_t> gate;          ///< its limit
};

RunResult score_run(const Scoring& scoring, std::uint32_t run_index, unsigned threads,
                    const std::function<void(std::size_t)>& advance) {
  const Dataset& dataset = scoring.dataset;
  const EvaluationOptions& options = scoring.options;
  const RunFolder folder = folder_of(dataset, run_index);
  const std::string name = name_of(dataset.runs()[run_index]);
  const std::vector<Sample> samples = samples_in(dataset, run_index);
  RunResult result;
  std::size_t next = 0;
  const auto see = [&](CameraTime tick, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
    if (next == samples.size() || tick != samples[next].t) return;
    result.samples.add(samples[next].touch, events, heatmap, scoring.classifier.input_size());
    ++next;
  };
  FullRun run = classify_full_run(folder.events(), scoring.classifier, threads, advance, see);
  for (const Sample& sample : samples) {
    const std::size_t k = place_of(sample, run.ticks, name);
    result.reliability.add(static_cast<double>(run.probabilities[k][static_cast<std::size_t>(run.verdicts[k])]),
                           run.verdicts[k] == sample.touch);
  }
  std::vector<Touch> open_verdicts;
  if (scoring.gate) {
    open_verdicts = confirmed(run.verdicts, options.confirmation);
    result.gated = apply_gate(run, *scoring.gate);
  }
  const std::vector<Touch> verdicts = confirmed(run.verdicts, options.confirmation);
  const RunTruth truth = read_run_truth(folder, member<bool>(dataset.settings(), "include_flagged", dataset.file().string()));
  const std::vector<TouchInterval> labelled = truth.used(), all = truth.all_labelled();

  result.ticks = run.verdicts.size();
  result.close_ticks = run.close;
  result.has_truth = truth.has_truth;
  for (const Sample& sample : samples) {
    const std::size_t k = place_of(sample, run.ticks, name);
    result.confusion.add(sample.touch, verdicts[k]);
    if (scoring.gate) result.open_confusion.add(sample.touch, open_verdicts[k]);
    if (truth.has_truth) result.true_confusion.add(touch_at(sample.t, truth.true_ones), verdicts[k]);
  }
  for (const microseconds guard : scoring.sampling_guards) {
    Confusion confusion;
    for (const Sample& sample :
         samples_by_guard(dataset, run_index, truth, run.ticks, scoring.classifier.rendering().history, guard))
      confusion.add(sample.touch, verdicts[place_of(sample, run.ticks, name)]);
    result.by_guard.push_back(confusion);
  }
  const auto score = [&](std::span<const Touch> said) {
    return score_of(run.ticks, said, labelled, all, truth.unlabelled, scoring.guard, options.delay);
  };
  result.network = score(verdicts);
  if (scoring.gate) result.open = score(open_verdicts);
  for (std::size_t i = 0; i < trivial_count; ++i)
    result.trivial[i] = score(trivial_verdicts(i, run.verdicts.size(), options.bootstrap.seed, name));
  for (const double threshold : default_thresholds())
    result.by_threshold.push_back(score(confirmed(verdicts_above(run.probabilities, threshold), options.confirmation)));
  std::vector<TouchInterval> elsewhere = all;
  elsewhere.insert(elsewhere.end(), truth.unlabelled.begin(), truth.unlabelled.end());
  result.over_time = over_time_of(run.ticks, verdicts, labelled, options.over_time, elsewhere);
  if (!truth.has_truth) return result;
  result.against_truth =
      score_of(run.ticks, verdicts, truth.true_ones, truth.true_ones, truth.unlabelled, scoring.guard, options.delay);
  for (std::size_t i = 0; i < truth.true_ones.size(); ++i) {
    if (truth.gross[i]) result.gross.push_back(counted_from(result.against_truth.detections[i], *truth.gross[i], run.ticks));
  }
  result.true_over_time = over_time_of(run.ticks, verdicts, truth.true_ones, options.over_time, truth.unlabelled);
  return result;
}

/// Calls `work` for each run with the threads it may use, and tells how many ticks are done.
void for_full_runs(const Dataset& dataset, const Classifier& classifier, std::span<const std::uint32_t> runs, unsigned threads,
                   const ProgressCallback& progress,
                   const std::function<void(std::size_t, unsigned, const std::function<void(std::size_t)>&)>& work) {
  std::vector<std::size_t> expected(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    check_unchanged(dataset, runs[i]);
    expected[i] = expected_ticks(folder_of(dataset, runs[i]).events(), classifier.rendering());
  });
  std::uint64_t total = 0, done = 0;
  for (const std::size_t ticks : expected) total += ticks;
  std::mutex guard_progress;
  const auto threads_each = std::max(1U, threads / std::max(1U, static_cast<unsigned>(runs.size())));
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    const auto advance = [&](std::size_t ticks) {
      const std::scoped_lock lock(guard_progress);
      done += ticks;
      tell(progress, done, total, "every tick of " + name_of(dataset.runs()[runs[i]]));
    };
    work(i, threads_each, advance);
  });
}

template <class RunScoreOf>
DetectorScore detector_score(std::span<const RunResult> runs, std::span<const std::string> objects,
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

/// One thing of each run's result, as tables over runs take it.
template <class Entry, class ValueOf>
std::vector<Entry> of_runs(std::span<const RunResult> runs, std::span<const std::string> objects, ValueOf value_of) {
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < runs.size(); ++i) entries.push_back({objects[i], value_of(runs[i])});
  return entries;
}

Confusion sum_of(std::span<const RunConfusion> runs) {
  Confusion sum;
  for (const RunConfusion& run : runs) sum += run.confusion;
  return sum;
}

/// Runs without a truth are left out.
TruthScore truth_score(std::span<const RunResult> runs, std::span<const std::string> objects, const EvaluationOptions& options) {
  std::vector<RunResult> with_truth;
  std::vector<std::string> their_objects;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].has_truth) continue;
    with_truth.push_back(runs[i]);
    their_objects.push_back(objects[i]);
  }
  const auto confusions =
      of_runs<RunConfusion>(with_truth, their_objects, [](const RunResult& run) { return run.true_confusion; });
  const DetectorScore detector = detector_score(with_truth, their_objects, options.bootstrap,
                                                [](const RunResult& run) -> const RunScore& { return run.against_truth; });
  const auto gross = of_runs<RunDetections>(with_truth, their_objects, [](const RunResult& run) { return run.gross; });
  const auto over_time = of_runs<RunOverTime>(with_truth, their_objects, [](const RunResult& run) { return run.true_over_time; });
  return {accuracy_of(confusions, options.bootstrap),
          sum_of(confusions),
          detector.press,
          detector.slip,
          delay_table(gross, Touch::slip, options.bootstrap),
          detector.false_alarms,
          accuracy_over_time(over_time, options.over_time, options.bootstrap)};
}

std::vector<microseconds> guards_beside(microseconds own) {
  std::vector<microseconds> guards{own};
  for (const microseconds other : {microseconds{100'000}, microseconds{0}}) {
    if (other != own) guards.push_back(other);
  }
  return guards;
}

}  // namespace

std::optional<bool> Evaluation::above_baselines() const {
  if (!accuracy.mean.low || baselines.empty()) return std::nullopt;
  bool above = true;
  for (const BaselineScore& baseline : baselines) {
    if (!baseline.accuracy.mean.high) return std::nullopt;
    above = above && *accuracy.mean.low > *baseline.accuracy.mean.high;
  }
  return above;
}

Evaluation evaluate(const Dataset& dataset, const Classifier& classifier, std::span<const std::uint32_t> test_runs,
                    const EvaluationOptions& options, const ProgressCallback& progress) {
  check_fits(dataset, classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  const ModelDescription& model = classifier.model();
  const BootstrapOptions& bootstrap = options.bootstrap;
  Evaluation evaluation;
  evaluation.model = {
      {"name", classifier.bundle().filename().string()}, {"settings", model.settings}, {"weights_sha256", model.weights_sha256}};
  evaluation.dataset = dataset.file().string();
  evaluation.manifest_hash = dataset.manifest_hash();
  evaluation.simulated = dataset.simulated();
  evaluation.guard = options.guard.value_or(dataset.sampling().guard);
  evaluation.sampling_guard = dataset.sampling().guard;
  evaluation.tick = classifier.rendering().tick;
  evaluation.confirmation = options.confirmation;
  evaluation.bootstrap = bootstrap;
  std::vector<std::string> objects;
  for (const std::uint32_t run : test_runs) {
    objects.push_back(dataset.runs()[run].object);
    evaluation.test_runs.push_back(name_of(dataset.runs()[run]));
  }

  // Full runs first: a run folder that has changed is told before anything else is worked on.
  const Scoring scoring{
      dataset, classifier, options, evaluation.guard, guards_beside(evaluation.sampling_guard), gate_of(classifier, options)};
  std::vector<RunResult> runs(test_runs.size());
  for_full_runs(dataset, classifier, test_runs, threads, progress,
                [&](std::size_t i, unsigned threads_each, const std::function<void(std::size_t)>& advance) {
                  runs[i] = score_run(scoring, test_runs[i], threads_each, advance);
                });

  evaluation.engine = classifier.engine();
  for (const RunResult& run : runs) evaluation.ticks += run.ticks, evaluation.close_ticks += run.close_ticks;
  evaluation.runs = of_runs<RunConfusion>(runs, objects, [](const RunResult& run) { return run.confusion; });
  evaluation.detections = of_runs<RunDetections>(runs, objects, [](const RunResult& run) { return run.network.detections; });
  evaluation.accuracy = accuracy_of(evaluation.runs, bootstrap);
  evaluation.confusion = sum_of(evaluation.runs);
  evaluation.classes = class_scores_of(evaluation.runs, bootstrap);
  evaluation.calibration =
      calibration_of(of_runs<RunReliability>(runs, objects, [](const RunResult& run) { return run.reliability; }), bootstrap);
  for (std::size_t i = 0; i < scoring.sampling_guards.size(); ++i) {
    const auto of_guard = of_runs<RunConfusion>(runs, objects, [i](const RunResult& run) { return run.by_guard[i]; });
    evaluation.guards.push_back({scoring.sampling_guards[i], accuracy_of(of_guard, bootstrap),
                                 accuracy_difference(evaluation.runs, of_guard, bootstrap), sum_of(of_guard)});
  }
  evaluation.network =
      detector_score(runs, objects, bootstrap, [](const RunResult& run) -> const RunScore& { return run.network; });
  if (scoring.gate) {
    GateOff& off = evaluation.gate_off.emplace();
    off.limit = *scoring.gate;
    for (const RunResult& run : runs) off.ticks += run.ticks, off.gated += run.gated;
    const auto open = of_runs<RunConfusion>(runs, objects, [](const RunResult& run) { return run.open_confusion; });
    off.accuracy = accuracy_of(open, bootstrap);
    off.confusion = sum_of(open);
    off.network = detector_score(runs, objects, bootstrap, [](const RunResult& run) -> const RunScore& { return run.open; });
  }
  for (std::size_t i = 0; i < trivial_count; ++i) {
    evaluation.trivial[trivial_names[i]] =
        detector_score(runs, objects, bootstrap, [i](const RunResult& run) -> const RunScore& { return run.trivial[i]; });
  }
  for (std::size_t i = 0; i < default_thresholds().size(); ++i) {
    evaluation.operating_curve.push_back(operating_point(
        default_thresholds()[i],
        of_runs<RunDetections>(runs, objects, [i](const RunResult& run) { return run.by_threshold[i].detections; }),
        of_runs<RunFalseAlarms>(runs, objects, [i](const RunResult& run) { return run.by_threshold[i].false_alarms; }),
        bootstrap));
  }
  evaluation.over_time = accuracy_over_time(
      of_runs<RunOverTime>(runs, objects, [](const RunResult& run) { return run.over_time; }), options.over_time, bootstrap);
  if (std::any_of(runs.begin(), runs.end(), [](const RunResult& run) { return run.has_truth; }))
    evaluation.truth = truth_score(runs, objects, options);

  RunSamples training;
  const std::vector<std::uint32_t> train_runs = training_runs_of(dataset, model);
  std::size_t step = 0;
  for (const std::uint32_t run : train_runs) {
    tell(progress, step++, train_runs.size(), "training samples of " + name_of(dataset.runs()[run]));
    add_samples(training, dataset, classifier, run, threads);
  }
  std::vector<RunSamples> tests;
  for (RunResult& run : runs) tests.push_back(std::move(run.samples));
  if (!training.truth.empty()) evaluation.baselines = baseline_scores(training, tests, objects, bootstrap);
  return evaluation;
}

std::string title_of(const Evaluation& evaluation) {
  return fmt::format("Evaluation of {} on {} runs", evaluation.model.at("name").get<std::string>(),
                     evaluation.simulated ? "simulated" : "real");
}

std::vector<RunConfusion> sample_confusions(const Dataset& dataset, const Classifier& classifier,
                                            std::span<const std::uint32_t> runs, const EvaluationOptions& options,
                                            const ProgressCallback& progress) {
  check_fits(dataset, classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  std::vector<RunConfusion> confusions(runs.size());
  const auto add = [&](std::size_t i, std::span<const Sample> samples, auto said_of) {
    confusions[i].object = dataset.runs()[runs[i]].object;
    for (std::size_t k = 0; k < samples.size(); ++k) confusions[i].confusion.add(samples[k].touch, said_of(k));
  };
  const std::optional<std::uint64_t> gate = gate_of(classifier, options);
  if (options.confirmation.of == 1 && !gate) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      tell(progress, i, runs.size(), "test samples of " + name_of(dataset.runs()[runs[i]]));
      const auto indexes = samples_of_runs(dataset, {&runs[i], 1});
      const auto said = classifier.verdicts(sample_heatmaps(dataset, classifier.rendering(), indexes, threads), threads);
      add(i, samples_in(dataset, runs[i]), [&](std::size_t k) { return said[k]; });
    }
    return confusions;
  }
  for_full_runs(dataset, classifier, runs, threads, progress,
                [&](std::size_t i, unsigned threads_each, const std::function<void(std::size_t)>& advance) {
                  FullRun run = classify_full_run(folder_of(dataset, runs[i]).events(), classifier, threads_each, advance);
                  if (gate) apply_gate(run, *gate);
                  const auto verdicts = confirmed(run.verdicts, options.confirmation);
                  const auto samples = samples_in(dataset, runs[i]);
                  add(i, samples,
                      [&](std::size_t k) { return verdicts[place_of(samples[k], run.ticks, name_of(dataset.runs()[runs[i]]))]; });
                });
  return confusions;
}

UnseenComparison compare_unseen(const Dataset& dataset, const Classifier& seen, const Classifier& held_out,
                                std::span<const std::uint32_t> runs, const EvaluationOptions& options,
                                const ProgressCallback& progress) {
  const auto by_seen = sample_confusions(dataset, seen, runs, options, progress);
  UnseenComparison comparison =
      unseen_comparison(by_seen, sample_confusions(dataset, held_out, runs, options, progress), options.bootstrap);
  comparison.models = {seen.bundle().filename().string(), held_out.bundle().filename().string()};
  for (const std::uint32_t run : runs) comparison.runs.push_back(name_of(dataset.runs()[run]));
  return comparison;
}

std::vector<std::uint32_t> runs_neither_saw(const Dataset& dataset, const ModelDescription& seen,
                                            const ModelDescription& held_out) {
  std::vector<std::uint32_t> runs = test_runs_of(dataset, held_out);
  std::erase_if(runs, [&](std::uint32_t run) { return learned_from(seen, dataset.runs()[run].events_sha256); });
  if (samples_of_runs(dataset, runs).empty()) {
    throw Error(
        fmt::format("{}: of the objects held out, no run with samples is left that neither model learned from; expected "
                    "two runs of one at least",
                    dataset.file().string()));
  }
  return runs;
}

}  // namespace tactile
