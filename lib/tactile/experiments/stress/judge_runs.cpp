#include "tactile/experiments/stress/judge_runs.hpp"

#include <fmt/core.h>

#include <mutex>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/stress/simulated_worlds.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;

/// Judges `count` runs side by side. Those without a cell are left out.
std::vector<results::Cell> for_each_run(const StressPlan& plan, std::size_t count, const ProgressCallback& progress,
                                        const std::function<std::optional<results::Cell>(std::size_t)>& judge) {
  std::vector<std::optional<results::Cell>> judged(count);
  std::mutex one_at_a_time;
  std::size_t done = 0;
  parallel_for(count, plan.options.judging.threads, [&](std::size_t i) {
    judged[i] = judge(i);
    const std::scoped_lock lock(one_at_a_time);
    report_progress(progress, ++done, count, fmt::format("judging every tick: {} of {} runs", done, count));
  });
  std::vector<results::Cell> cells;
  for (std::optional<results::Cell>& cell : judged) {
    if (cell) cells.push_back(std::move(*cell));
  }
  return cells;
}

/// The model of a training, and how its predictions become verdicts.
struct OpenTraining {
  OpenTraining(const StressPlan& plan, const StressTraining& training)
      : classifier(model::open_classifier(training.bundle.folder, 1, plan.options.engine)) {
    options = {.decision = model::usual_decision(classifier.kind(), {}), .delay = plan.options.judging.delay, .threads = 1};
    if (plan.dataset) options.include_flagged = evaluation::includes_flagged(*plan.dataset);
  }

  model::Classifier classifier;
  evaluation::PredictionOptions options{};
};

results::Cell cell_of(const evaluation::RunPrediction& prediction, const RunFolder& run, const StressTraining& training,
                      std::span<const windows::Sample> samples) {
  results::Cell cell = prediction.judged;
  cell.object = run.object;
  cell.run = run.run;
  cell.setting = training.bundle.name();
  for (const windows::Sample& sample : samples) {
    const std::size_t tick = evaluation::place_of(sample, prediction.full.ticks, run.name());
    cell.samples.add(sample.touch, prediction.verdicts[tick]);
  }
  return cell;
}

/// Of a run without samples.
std::optional<results::Cell> judged_if_read(const RunFolder& run, const model::Classifier& classifier,
                                            const evaluation::PredictionOptions& options, const StressTraining& training) {
  try {
    return cell_of(evaluation::predict_run(run, classifier, options), run, training, {});
  } catch (const Error&) {  // the others are judged all the same
    return std::nullopt;
  }
}

}  // namespace

std::vector<results::Cell> judged_runs(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                       double severity, JudgedBy by, const ProgressCallback& progress) {
  const windows::Dataset& dataset = *plan.dataset;
  const OpenTraining open(plan, training);
  const bool in_world = series != nullptr && !series->world.empty();
  return for_each_run(plan, training.runs.size(), progress, [&](std::size_t i) -> std::optional<results::Cell> {
    auto [run, index] = training.runs[i];
    evaluation::PredictionOptions options = open.options;
    options.by_truth = in_world || by == JudgedBy::truth;
    if (in_world)
      run = simulated_in_world(run, series->world, severity, plan.options.out / "worlds");
    else if (series != nullptr)
      options.change = change_by(*series, severity, run.name(), dataset.sensor());
    if (!index) return judged_if_read(run, open.classifier, options, training);
    const evaluation::RunPrediction prediction = evaluation::predict_run(run, open.classifier, options);
    if (!options.by_truth) return cell_of(prediction, run, training, evaluation::samples_in(dataset, *index));
    const std::vector<windows::Sample> samples =
        evaluation::samples_by(dataset.sampling(), *index, run, prediction.truth.labels, prediction.truth, prediction.full.ticks,
                               open.classifier.rendering().history);
    return cell_of(prediction, run, training, samples);
  });
}

std::vector<results::Cell> judged_quiet(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                        double severity, const ProgressCallback& progress) {
  const OpenTraining open(plan, training);
  const std::vector<fs::path>& files = plan.options.quiet;
  return for_each_run(plan, files.size(), progress, [&](std::size_t i) {
    heatmaps::ChangeEvents change;
    if (series != nullptr) {
      const events::RecordingReader reader(files[i]);
      const std::optional<events::SensorSize> size = events::event_stream(reader).size;
      if (!size) throw Error(files[i].string() + ": its event stream declares no size; expected that of its sensor");
      change = change_by(*series, severity, files[i].filename().string(), *size);
    }
    const results::FullRun full = evaluation::classify_full_run(files[i], open.classifier, {.change = change});
    results::Cell cell = evaluation::RunJudge(full.ticks, {}).judged(evaluation::decided(open.options.decision, full));
    cell.object = files[i].filename().string();
    cell.run = std::to_string(i + 1);
    cell.setting = training.bundle.name();
    return cell;
  });
}

}  // namespace tactile::stress
