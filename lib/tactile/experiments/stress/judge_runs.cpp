#include "tactile/experiments/stress/judge_runs.hpp"

#include <fmt/core.h>

#include <mutex>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/stress/simulated_worlds.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::stress {
namespace {

namespace fs = std::filesystem;

/// Judges `count` runs side by side.
std::vector<RunOutcome> for_each_run(const StressPlan& plan, std::size_t count, const ProgressCallback& progress,
                                     const std::function<RunOutcome(std::size_t)>& judge) {
  std::vector<RunOutcome> outcomes(count);
  std::mutex one_at_a_time;
  std::size_t done = 0;
  parallel_for(count, plan.options.judging.threads, [&](std::size_t i) {
    outcomes[i] = judge(i);
    const std::scoped_lock lock(one_at_a_time);
    report_progress(progress, ++done, count, fmt::format("judging every tick: {} of {} runs", done, count));
  });
  return outcomes;
}

/// The model of a training, and how its predictions become verdicts.
struct OpenTraining {
  OpenTraining(const StressPlan& plan, const StressTraining& training)
      : classifier(model::open_classifier(training.bundle.folder, 1, plan.options.engine)) {
    const evaluation::EvaluationOptions& judging = plan.options.judging;
    options = {.decision = evaluation::decision_of(classifier, judging),
               .gate = evaluation::gate_of(classifier, judging),
               .delay = judging.delay,
               .threads = 1};
    if (plan.dataset) {
      options.guard = judging.guard.value_or(plan.dataset->sampling().guard);
      options.include_flagged = member<bool>(plan.dataset->settings(), "include_flagged", plan.dataset->file().string());
    }
  }

  model::Classifier classifier;
  evaluation::PredictionOptions options{};
};

RunOutcome outcome_of(const evaluation::RunPrediction& prediction, const RunFolder& run,
                      std::span<const windows::Sample> samples) {
  RunOutcome outcome;
  outcome.object = run.object;
  outcome.run = run.run;
  outcome.detections = prediction.detections;
  outcome.alarms = prediction.false_alarms;
  outcome.close_ticks = prediction.full.close;
  for (const windows::Sample& sample : samples) {
    const std::size_t tick = evaluation::place_of(sample, prediction.full.ticks, run.name());
    outcome.confusion.add(sample.touch, prediction.verdicts[tick]);
  }
  return outcome;
}

}  // namespace

std::vector<RunOutcome> judged_runs(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                    double severity, JudgedBy by, const ProgressCallback& progress) {
  const windows::Dataset& dataset = *plan.dataset;
  const OpenTraining open(plan, training);
  const bool in_world = series != nullptr && !series->world.empty();
  return for_each_run(plan, training.runs.size(), progress, [&](std::size_t i) {
    const std::uint32_t index = training.runs[i];
    RunFolder run = evaluation::folder_of(dataset, index);
    evaluation::PredictionOptions options = open.options;
    options.by_truth = in_world || by == JudgedBy::truth;
    if (in_world)
      run = simulated_in_world(run, series->world, severity, plan.options.out / "worlds");
    else if (series != nullptr)
      options.change = change_by(*series, severity, run.name(), dataset.sensor());
    const evaluation::RunPrediction prediction = evaluation::predict_run(run, open.classifier, options);
    if (!options.by_truth) return outcome_of(prediction, run, evaluation::samples_in(dataset, index));
    const std::vector<windows::Sample> samples =
        evaluation::samples_by(dataset.sampling(), index, run, prediction.truth.labels, prediction.truth, prediction.full.ticks,
                               open.classifier.rendering().history);
    return outcome_of(prediction, run, samples);
  });
}

std::vector<RunOutcome> judged_quiet(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
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
    results::FullRun full = evaluation::classify_full_run(
        files[i], open.classifier, {.change = change, .ratios = evaluation::needs_ratios(open.options.gate)});
    if (open.options.gate) evaluation::apply_gate(full, *open.options.gate);
    RunOutcome outcome;
    outcome.object = files[i].filename().string();
    outcome.run = std::to_string(i + 1);
    outcome.close_ticks = full.close;
    outcome.alarms = evaluation::false_alarms_of(full.ticks, evaluation::decided(open.options.decision, full), {}, {});
    return outcome;
  });
}

void write_outcomes(const fs::path& file, std::span<const RunOutcome> outcomes) {
  nlohmann::json runs = nlohmann::json::array();
  for (const RunOutcome& outcome : outcomes) {
    runs.push_back({{"object", outcome.object},
                    {"run", outcome.run},
                    {"confusion", outcome.confusion},
                    {"intervals", outcome.detections},
                    {"false_alarms", outcome.alarms},
                    {"close_ticks", outcome.close_ticks}});
  }
  write_whole(file, nlohmann::json{{"runs", runs}}.dump() + "\n");
}

std::vector<RunOutcome> read_outcomes(const fs::path& file, std::size_t training) {
  const auto json = nlohmann::json::parse(read_text(file, experiments::largest_step_file), nullptr, false);
  if (json.is_discarded()) throw Error(file.string() + ": no JSON; expected the outcomes of runs");
  std::vector<RunOutcome> outcomes;
  const results::JsonView view(json, file.string(), results::MissingMember::is_error);
  for (const results::JsonView& run : view["runs"].items()) {
    RunOutcome& outcome = outcomes.emplace_back();
    outcome.object = run["object"].text();
    outcome.run = run["run"].text();
    outcome.training = training;
    outcome.confusion = run["confusion"].get<results::Confusion>();
    outcome.detections = run["intervals"].list_of<results::Detection>();
    outcome.alarms = run["false_alarms"].get<results::FalseAlarms>();
    outcome.close_ticks = run["close_ticks"].count();
  }
  return outcomes;
}

}  // namespace tactile::stress
