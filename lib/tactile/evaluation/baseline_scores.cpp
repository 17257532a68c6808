#include "tactile/evaluation/baseline_scores.hpp"

#include <algorithm>

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
    if (model::learned_from(model, dataset.runs()[run].events_sha256) &&
        std::find(named.begin(), named.end(), name_of(dataset.runs()[run])) != named.end())
      runs.push_back(run);
  }
  return runs;
}

void add_samples(BaselineSamples& samples, const windows::Dataset& dataset, const model::Classifier& classifier,
                 std::uint32_t run, unsigned threads) {
  const auto indexes = model::samples_of_runs(dataset, {&run, 1});
  const auto heatmaps = model::sample_heatmaps(dataset, classifier.rendering(), indexes, threads);
  const auto events = windows::event_counts(dataset, run, indexes, classifier.rendering().history, classifier.rendering().mask);
  const std::size_t cells = indexes.empty() ? 0 : heatmaps.size() / indexes.size();
  for (std::size_t i = 0; i < indexes.size(); ++i) {
    samples.add(dataset.samples()[indexes[i]].touch, events[i], std::span(heatmaps).subspan(i * cells, cells),
                classifier.input_size());
  }
}

}  // namespace

BaselineSamples training_samples(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads,
                                 const ProgressCallback& progress) {
  BaselineSamples training;
  const std::vector<std::uint32_t> runs = training_runs_of(dataset, classifier.model());
  std::size_t step = 0;
  for (const std::uint32_t run : runs) {
    tell(progress, step++, runs.size(), "training samples of " + name_of(dataset.runs()[run]));
    add_samples(training, dataset, classifier, run, threads);
  }
  return training;
}

std::vector<results::BaselineScore> baseline_scores(const BaselineSamples& training, std::span<const BaselineSamples> tests,
                                                    std::span<const std::string> objects,
                                                    const results::BootstrapOptions& bootstrap) {
  if (training.truth.empty()) return {};
  const MajorityBaseline majority = fit_majority(training.truth);
  const EventCountBaseline event_count = fit_event_count(training.events, training.truth);
  const LogisticBaseline by_moments = fit_logistic(training.moments, training.truth);
  const LogisticBaseline by_fields = fit_logistic(training.fields, training.truth);
  const auto score = [&](const std::string& name, auto verdict) {
    std::vector<results::RunConfusion> runs;
    for (std::size_t i = 0; i < tests.size(); ++i) {
      results::RunConfusion run{objects[i], {}};
      for (std::size_t k = 0; k < tests[i].truth.size(); ++k) run.confusion.add(tests[i].truth[k], verdict(tests[i], k));
      runs.push_back(run);
    }
    return results::BaselineScore{name, accuracy_of(runs, bootstrap)};
  };
  return {
      score("majority", [&](const BaselineSamples&, std::size_t) { return majority.touch; }),
      score("event_count", [&](const BaselineSamples& run, std::size_t k) { return event_count.verdict(run.events[k]); }),
      score("logistic_moments", [&](const BaselineSamples& run, std::size_t k) { return by_moments.verdict(run.moments[k]); }),
      score("logistic_position", [&](const BaselineSamples& run, std::size_t k) { return by_fields.verdict(run.fields[k]); })};
}

}  // namespace tactile::evaluation
