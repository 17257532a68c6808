#include "tactile/evaluation/baseline_scores.hpp"

#include <algorithm>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/features/step_features.hpp"
#include "tactile/features/tick_features.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "tactile/model/inference/temporal_network.hpp"
#include "tactile/model/training/fit_temporal.hpp"
#include "tactile/model/training/fit_trees.hpp"
#include "tactile/model/training/sample_features.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/event_counts.hpp"

namespace tactile::evaluation {
namespace {

/// The dataset's runs that the model learned from directly; the baselines are fitted on them.
std::vector<std::uint32_t> training_runs_of(const windows::Dataset& dataset, const model::ModelDescription& model) {
  if (model.manifest_hash == dataset.manifest_hash()) return model::split_of(dataset, model.settings.split).train_runs;
  std::vector<std::uint32_t> runs;
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    const auto& named = model.train_runs;
    if (model::learned_from(model, dataset.runs()[run]) &&
        std::find(named.begin(), named.end(), name_of(dataset.runs()[run])) != named.end())
      runs.push_back(run);
  }
  return runs;
}

/// The baselines of one training.
struct FittedBaselines {
  MajorityBaseline majority;
  EventCountBaseline event_count;
  LogisticBaseline moments, fields;
  std::optional<model::BoostedTrees> trees;
  std::optional<model::TemporalNetwork> temporal;
};

/// Whether a kind without heatmaps can read this history.
bool can_read(model::ModelKind kind, const heatmaps::HeatmapOptions& rendering) {
  model::ModelSettings settings;
  settings.kind = kind;
  settings.rendering = rendering;
  try {
    check_history(settings);
    return true;
  } catch (const Error&) {
    return false;
  }
}

std::optional<model::TemporalNetwork> temporal_of(const BaselineSamples& training, std::uint64_t seed) {
  if (training.steps.empty()) return std::nullopt;
  const model::TemporalOptions options;
  return model::TemporalNetwork(options, model::fit_temporal(training.steps, training.truth, options, {.seed = seed}).weights);
}

std::optional<model::BoostedTrees> trees_of(const BaselineSamples& training, std::uint64_t seed) {
  if (training.features.empty()) return std::nullopt;
  return model::fit_trees(training.features, training.truth, {}, seed);
}

}  // namespace

void add_features(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                  std::uint32_t run) {
  const std::vector<std::uint32_t> indexes = model::samples_of_runs(dataset, {&run, 1});
  const auto add = [&](model::ModelKind kind, const auto& of_run, std::vector<float>& all) {
    if (!can_read(kind, classifier.rendering())) return;
    const std::vector<float> more = of_run(dataset, run, indexes, classifier.rendering());
    all.insert(all.end(), more.begin(), more.end());
  };
  add(model::ModelKind::trees, model::sample_features, samples.features);
  add(model::ModelKind::temporal, model::sample_steps, samples.steps);
}

void add_samples(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                 std::uint32_t run, unsigned threads) {
  const auto indexes = model::samples_of_runs(dataset, {&run, 1});
  const auto heatmaps = model::sample_heatmaps(dataset, classifier.rendering(), indexes, threads);
  const auto events = windows::event_counts(dataset, run, indexes, classifier.rendering().history, classifier.rendering().mask);
  const events::SensorSize size = heatmaps::heatmap_size(dataset.sensor(), classifier.rendering().factor);
  const std::size_t cells = indexes.empty() ? 0 : heatmaps.size() / indexes.size();
  for (std::size_t i = 0; i < indexes.size(); ++i) {
    samples.add(dataset.samples()[indexes[i]].touch, events[i], std::span(heatmaps).subspan(i * cells, cells), size);
  }
  add_features(samples, dataset, classifier, run);
}

BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress) {
  BaselineSamples training;
  const std::vector<std::uint32_t> runs = training_runs_of(dataset, classifier.model());
  std::size_t step = 0;
  for (const std::uint32_t run : runs) {
    report_progress(progress, step++, runs.size(), "training samples of " + name_of(dataset.runs()[run]));
    add_samples(training, dataset, classifier, run, threads);
  }
  return training;
}

std::vector<results::BaselineScore> baseline_scores(std::span<const BaselineSamples> trainings,
                                                    std::span<const BaselineSamples> tests,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap) {
  std::vector<FittedBaselines> fitted;
  for (const BaselineSamples& training : trainings) {
    if (training.truth.empty()) return {};
    fitted.push_back({fit_majority(training.truth), fit_event_count(training.events, training.truth),
                      fit_logistic(training.moments, training.truth), fit_logistic(training.fields, training.truth),
                      trees_of(training, bootstrap.seed), temporal_of(training, bootstrap.seed)});
  }
  const auto score = [&](const std::string& name, auto verdict) {
    std::vector<results::RunConfusion> confusions;
    for (std::size_t i = 0; i < tests.size(); ++i) {
      results::RunConfusion run{runs[i], {}};
      for (std::size_t k = 0; k < tests[i].truth.size(); ++k)
        run.confusion.add(tests[i].truth[k], verdict(fitted[runs[i].training], tests[i], k));
      confusions.push_back(run);
    }
    return results::BaselineScore{name, accuracy_of(confusions, bootstrap)};
  };
  using Fitted = const FittedBaselines&;
  using Samples = const BaselineSamples&;
  std::vector<results::BaselineScore> scores{
      score("majority", [](Fitted by, Samples, std::size_t) { return by.majority.touch; }),
      score("event_count", [](Fitted by, Samples run, std::size_t k) { return by.event_count.verdict(run.events[k]); }),
      score("logistic_moments", [](Fitted by, Samples run, std::size_t k) { return by.moments.verdict(run.moments[k]); }),
      score("logistic_position", [](Fitted by, Samples run, std::size_t k) { return by.fields.verdict(run.fields[k]); })};
  const auto all_have = [&](auto model, std::vector<float> BaselineSamples::*input) {
    return std::all_of(fitted.begin(), fitted.end(), [&](Fitted by) { return (by.*model).has_value(); }) &&
           std::none_of(tests.begin(), tests.end(), [&](Samples run) { return (run.*input).empty() && !run.truth.empty(); });
  };
  if (all_have(&FittedBaselines::trees, &BaselineSamples::features)) {
    scores.push_back(score("boosted_trees", [](Fitted by, Samples run, std::size_t k) {
      return model::verdict_of(
          by.trees->logits(std::span(run.features).subspan(k * features::feature_count, features::feature_count)));
    }));
  }
  if (all_have(&FittedBaselines::temporal, &BaselineSamples::steps)) {
    scores.push_back(score("temporal_convolution", [](Fitted by, Samples run, std::size_t k) {
      return model::verdict_of(
          by.temporal->logits(std::span(run.steps).subspan(k * features::step_values, features::step_values)));
    }));
  }
  return scores;
}

}  // namespace tactile::evaluation
