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

FittedBaselines::FittedBaselines(const BaselineSamples& training, std::uint64_t seed) {
  if (training.truth.empty()) return;
  fitted_ = Fitted{fit_majority(training.truth),
                   fit_event_count(training.events, training.truth),
                   fit_logistic(training.moments, training.truth),
                   fit_logistic(training.fields, training.truth),
                   trees_of(training, seed),
                   temporal_of(training, seed)};
}

BaselineConfusions FittedBaselines::confusions_of(const BaselineSamples& run) const {
  BaselineConfusions confusions;
  if (!fitted_) return confusions;
  const Fitted& by = *fitted_;
  const auto confusion_by = [&](auto verdict) {
    results::Confusion confusion;
    for (std::size_t k = 0; k < run.truth.size(); ++k) confusion.add(run.truth[k], verdict(k));
    return confusion;
  };
  const auto part = [](const std::vector<float>& all, std::size_t k, std::size_t length) {
    return std::span(all).subspan(k * length, length);
  };
  confusions[0] = confusion_by([&](std::size_t) { return by.majority.touch; });
  confusions[1] = confusion_by([&](std::size_t k) { return by.event_count.verdict(run.events[k]); });
  confusions[2] = confusion_by([&](std::size_t k) { return by.moments.verdict(run.moments[k]); });
  confusions[3] = confusion_by([&](std::size_t k) { return by.fields.verdict(run.fields[k]); });
  if (by.trees && (run.truth.empty() || !run.features.empty())) {
    confusions[4] = confusion_by(
        [&](std::size_t k) { return model::verdict_of(by.trees->logits(part(run.features, k, features::feature_count))); });
  }
  if (by.temporal && (run.truth.empty() || !run.steps.empty())) {
    confusions[5] = confusion_by(
        [&](std::size_t k) { return model::verdict_of(by.temporal->logits(part(run.steps, k, features::step_values))); });
  }
  return confusions;
}

std::vector<results::BaselineScore> baseline_scores(std::span<const BaselineConfusions> confusions,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap) {
  std::vector<results::BaselineScore> scores;
  for (std::size_t baseline = 0; baseline < baseline_names.size(); ++baseline) {
    std::vector<results::RunConfusion> of_runs;
    for (std::size_t i = 0; i < runs.size() && confusions[i][baseline]; ++i)
      of_runs.push_back({runs[i], *confusions[i][baseline]});
    if (of_runs.size() == runs.size()) scores.push_back({baseline_names[baseline], accuracy_of(of_runs, bootstrap)});
  }
  return scores;
}

}  // namespace tactile::evaluation
