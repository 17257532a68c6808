#include <fmt/core.h>

#include <algorithm>
#include <mutex>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/model/training/sample_logits.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::evaluation {

std::vector<results::Cell> judge_samples(const windows::Dataset& dataset, const ModelOnRuns& training,
                                         const EvaluationOptions& options, const ProgressCallback& progress) {
  const model::Classifier& classifier = *training.classifier;
  const std::vector<std::uint32_t>& runs = training.runs;
  check_fits(dataset, classifier, options);
  const unsigned threads = threads_or_all(options.threads);
  std::vector<results::Cell> cells(runs.size());
  const auto add = [&](std::size_t i, std::span<const windows::Sample> samples, auto predicted_of) {
    const RunFolder folder = folder_of(dataset, runs[i]);
    cells[i].world = read_run_truth(folder).world;
    cells[i].object = folder.object;
    cells[i].run = folder.run;
    for (std::size_t k = 0; k < samples.size(); ++k) cells[i].samples.add(samples[k].touch, predicted_of(k));
  };
  if (options.confirmation.of == 1 && !options.thresholds) {
    // One run is read while others are classified.
    std::mutex reads;
    std::size_t begun = 0;
    const auto predicted_of = [&](std::size_t i, std::span<const std::uint32_t> indexes) {
      std::unique_lock lock(reads);
      report_progress(progress, begun++, runs.size(), "test samples of " + name_of(dataset.runs()[runs[i]]));
      if (reads_heatmaps(classifier.kind())) {
        const auto heatmaps = model::sample_heatmaps(dataset, classifier.rendering(), indexes, threads);
        lock.unlock();
        return classifier.verdicts(heatmaps, 1);
      }
      lock.unlock();
      const auto logits = model::sample_logits(dataset, classifier, indexes, 1);
      std::vector<Touch> verdicts(logits.size());
      std::transform(logits.begin(), logits.end(), verdicts.begin(), model::verdict_of);
      return verdicts;
    };
    parallel_for(runs.size(), threads, [&](std::size_t i) {
      const auto indexes = model::samples_of_runs(dataset, {&runs[i], 1});
      const auto predicted = predicted_of(i, indexes);
      add(i, samples_in(dataset, runs[i]), [&](std::size_t k) { return predicted[k]; });
    });
    return cells;
  }
  for_full_runs(dataset, runs, ticks_of_unchanged(dataset, classifier, runs, threads), threads, progress,
                [&](std::size_t i, const std::function<void(std::size_t)>& advance) {
                  const results::FullRun run = classify_full_run(folder_of(dataset, runs[i]).events(), classifier,
                                                                 {.threads = threads, .advance = advance});
                  const auto verdicts = decided(decision_of(options), run);
                  const auto samples = samples_in(dataset, runs[i]);
                  add(i, samples,
                      [&](std::size_t k) { return verdicts[place_of(samples[k], run.ticks, name_of(dataset.runs()[runs[i]]))]; });
                });
  return cells;
}

results::UnseenComparison compare_unseen(const windows::Dataset& dataset, std::span<const UnseenPair> pairs,
                                         const EvaluationOptions& options, const ProgressCallback& progress) {
  std::vector<results::Cell> seen, held_out;
  for (std::size_t training = 0; training < pairs.size(); ++training) {
    const UnseenPair& pair = pairs[training];
    const auto add = [&](std::vector<results::Cell>& all, const model::Classifier& classifier) {
      for (results::Cell& cell : judge_samples(dataset, {&classifier, pair.runs}, options, progress)) {
        cell.training = training;
        all.push_back(std::move(cell));
      }
    };
    add(seen, *pair.seen);
    add(held_out, *pair.held_out);
  }
  results::UnseenComparison comparison = unseen_comparison(seen, held_out, options.bootstrap);
  comparison.models = {pairs.front().seen->bundle().filename().string(), pairs.front().held_out->bundle().filename().string()};
  return comparison;
}

std::vector<std::uint32_t> runs_neither_saw(const windows::Dataset& dataset, const model::ModelDescription& seen,
                                            const model::ModelDescription& held_out) {
  std::vector<std::uint32_t> runs = model::test_runs_of(dataset, held_out);
  std::erase_if(runs, [&](std::uint32_t run) { return model::learned_from(seen, dataset.runs()[run]); });
  if (model::samples_of_runs(dataset, runs).empty()) {
    throw Error(
        fmt::format("{}: every run of the held-out objects with samples was used to train one of the models; expected "
                    "another run of one of them",
                    dataset.file().string()));
  }
  return runs;
}

}  // namespace tactile::evaluation
