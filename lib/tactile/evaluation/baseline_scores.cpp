#include "tactile/evaluation/baseline_scores.hpp"

#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
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

}  // namespace

void BaselineSamples::append(const BaselineSamples& more) {
  const auto add = [](auto& all, const auto& further) { all.insert(all.end(), further.begin(), further.end()); };
  add(truth, more.truth);
  add(events, more.events);
  add(moments, more.moments);
  add(fields, more.fields);
  add(features, more.features);
  add(steps, more.steps);
}

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

BaselineSamples samples_of(const windows::Dataset& dataset, const model::Classifier& classifier, std::uint32_t run,
                           unsigned threads) {
  BaselineSamples samples;
  const auto indexes = model::samples_of_runs(dataset, {&run, 1});
  const auto heatmaps = model::sample_heatmaps(dataset, classifier.rendering(), indexes, threads);
  const auto events = windows::event_counts(dataset, run, indexes, classifier.rendering().history, classifier.rendering().mask);
  const events::SensorSize size = heatmaps::heatmap_size(dataset.sensor(), classifier.rendering().factor);
  const std::size_t cells = indexes.empty() ? 0 : heatmaps.size() / indexes.size();
  for (std::size_t i = 0; i < indexes.size(); ++i) {
    samples.add(dataset.samples()[indexes[i]].touch, events[i], std::span(heatmaps).subspan(i * cells, cells), size);
  }
  add_features(samples, dataset, classifier, run);
  return samples;
}

BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress) {
  const std::vector<std::uint32_t> runs = training_runs_of(dataset, classifier.model());
  std::vector<BaselineSamples> of_runs(runs.size());
  std::mutex guard_progress;
  std::size_t done = 0;
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    of_runs[i] = samples_of(dataset, classifier, runs[i], 1);
    const std::scoped_lock lock(guard_progress);
    report_progress(progress, ++done, runs.size(), "training samples of " + name_of(dataset.runs()[runs[i]]));
  });
  BaselineSamples training;
  for (BaselineSamples& samples : of_runs) {
    training.append(samples);
    samples = {};
  }
  return training;
}

FittedBaselines::FittedBaselines(BaselineSamples training, std::uint64_t seed)
    : training_(std::move(training)), has_samples_(!training_.truth.empty()), seed_(seed) {}

void FittedBaselines::fit(std::size_t part) {
  // The longest comes first.
  constexpr std::array fits{&FittedBaselines::fit_trees, &FittedBaselines::fit_temporal, &FittedBaselines::fit_simple};
  static_assert(fits.size() == parts);
  if (has_samples_) (this->*fits[part])();
  if (++fitted_ == parts) training_ = {};  // nothing reads it any more
}

void FittedBaselines::fit_trees() {
  if (!training_.features.empty()) trees_ = model::fit_trees(training_.features, training_.truth, {}, seed_);
}

void FittedBaselines::fit_temporal() {
  if (training_.steps.empty()) return;
  const model::TemporalOptions options;
  temporal_.emplace(options, model::fit_temporal(training_.steps, training_.truth, options, {.seed = seed_}).weights);
}

void FittedBaselines::fit_simple() {
  majority_ = fit_majority(training_.truth);
  event_count_ = fit_event_count(training_.events, training_.truth);
  moments_ = fit_logistic(training_.moments, training_.truth);
  fields_ = fit_logistic(training_.fields, training_.truth);
}

BaselineConfusions FittedBaselines::confusions_of(const BaselineSamples& run) const {
  BaselineConfusions confusions;
  if (!has_samples_) return confusions;
  const auto confusion_by = [&](auto verdict) {
    results::Confusion confusion;
    for (std::size_t k = 0; k < run.truth.size(); ++k) confusion.add(run.truth[k], verdict(k));
    return confusion;
  };
  const auto part = [](const std::vector<float>& all, std::size_t k, std::size_t length) {
    return std::span(all).subspan(k * length, length);
  };
  confusions[0] = confusion_by([&](std::size_t) { return majority_.touch; });
  confusions[1] = confusion_by([&](std::size_t k) { return event_count_.verdict(run.events[k]); });
  confusions[2] = confusion_by([&](std::size_t k) { return moments_.verdict(run.moments[k]); });
  confusions[3] = confusion_by([&](std::size_t k) { return fields_.verdict(run.fields[k]); });
  if (trees_ && (run.truth.empty() || !run.features.empty())) {
    confusions[4] = confusion_by(
        [&](std::size_t k) { return model::verdict_of(trees_->logits(part(run.features, k, features::feature_count))); });
  }
  if (temporal_ && (run.truth.empty() || !run.steps.empty())) {
    confusions[5] = confusion_by(
        [&](std::size_t k) { return model::verdict_of(temporal_->logits(part(run.steps, k, features::step_values))); });
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
