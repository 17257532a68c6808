#include "tactile/evaluation/baseline_scores.hpp"

#include <algorithm>
#include <mutex>

#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/accuracy.hpp"
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

}  // namespace

void BaselineSamples::append(const BaselineSamples& more) {
  const auto add = [](auto& all, const auto& further) { all.insert(all.end(), further.begin(), further.end()); };
  add(truth, more.truth);
  add(events, more.events);
  add(moments, more.moments);
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

FittedBaselines::FittedBaselines(const BaselineSamples& training)
    : majority_(fit_majority(training.truth)),
      event_count_(fit_event_count(training.events, training.truth)),
      moments_(fit_logistic(training.moments, training.truth)) {}

BaselineConfusions FittedBaselines::confusions_of(const BaselineSamples& run) const {
  const auto confusion_by = [&](auto verdict) {
    results::Confusion confusion;
    for (std::size_t k = 0; k < run.truth.size(); ++k) confusion.add(run.truth[k], verdict(k));
    return confusion;
  };
  return {confusion_by([&](std::size_t) { return majority_.touch; }),
          confusion_by([&](std::size_t k) { return event_count_.verdict(run.events[k]); }),
          confusion_by([&](std::size_t k) { return moments_.verdict(run.moments[k]); })};
}

std::vector<results::BaselineScore> baseline_scores(std::span<const std::optional<BaselineConfusions>> confusions,
                                                    std::span<const results::JudgedRun> runs,
                                                    const results::BootstrapOptions& bootstrap) {
  std::vector<results::BaselineScore> scores;
  if (!std::all_of(confusions.begin(), confusions.end(), [](const auto& of_run) { return of_run.has_value(); })) return scores;
  for (std::size_t baseline = 0; baseline < baseline_names.size(); ++baseline) {
    std::vector<results::RunConfusion> of_runs;
    for (std::size_t i = 0; i < runs.size(); ++i) of_runs.push_back({runs[i], (*confusions[i])[baseline]});
    scores.push_back({baseline_names[baseline], accuracy_of(of_runs, bootstrap)});
  }
  return scores;
}

}  // namespace tactile::evaluation
