#include "tactile/experiments/study/judge_models.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <deque>
#include <numeric>

#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// With another number, what is kept is made again.
constexpr int evaluation_form = 5;
constexpr int run_form = 6;  ///< of the run over time

/// Null if one of them is missing.
json hashes_of(std::initializer_list<fs::path> files) {
  json hashes = json::object();
  for (const fs::path& file : files) {
    const json hash = experiments::hash_of_file(file);
    if (hash.is_null()) return {};
    hashes[file.filename().string()] = hash;
  }
  return hashes;
}

evaluation::Evaluated evaluated(const StudyPlan& plan, const std::vector<StudyModel>& models, const NamedRunSet& set,
                                const ProgressCallback& progress) {
  const unsigned threads = plan.options.threads;
  std::deque<model::Classifier> classifiers;
  std::vector<evaluation::ModelOnRuns> trainings;
  for (const StudyModel& model : models) {
    classifiers.push_back(model::open_classifier(model.bundle.folder, threads, plan.options.engine));
    trainings.push_back({&classifiers.back(), (plan.trainings[model.training].*set.runs).runs});
  }
  return evaluation::evaluate(plan.dataset, trainings, {.threads = threads}, progress);
}

void evaluate_on(const StudyPlan& plan, const std::vector<StudyModel>& models, const NamedRunSet& set,
                 experiments::StepRunner& runner, std::vector<EvaluatedModels>& evaluations) {
  for (const EvaluatedModels& other : evaluations) {
    const bool same = std::equal(models.begin(), models.end(), other.models.begin(), [&](const auto& a, const auto& b) {
      const PlannedTraining& training = plan.trainings[a.training];
      return a.name() == b.name() && training.reported.runs == training.all_test.runs;
    });
    if (same) {
      evaluations.push_back({set.name, models, other.json_file, other.csv_file});
      return;
    }
  }
  const fs::path stem = plan.options.out / "evaluations" / set.name;
  const fs::path json_file = stem.string() + ".json", csv_file = stem.string() + "-cells.csv";
  nlohmann::json trainings = nlohmann::json::array();
  for (const StudyModel& model : models) {
    const RunSet& runs = plan.trainings[model.training].*set.runs;
    trainings.push_back({{"name", model.name()},
                         {"weights", model::read_description(model.bundle).weights_sha256},
                         {"truth", experiments::truth_hashes(evaluation::folders_of(plan.dataset, runs.runs))},
                         {"others", experiments::hashes_of_runs(evaluation::other_runs(plan.dataset, runs.runs).runs)},
                         {"runs", runs.names}});
  }
  runner.run(
      {.name = fmt::format("evaluate-{}", set.name),
       .command = "",
       .inputs = with_engine({{"manifest", plan.dataset.manifest_hash()}, {"trainings", trainings}, {"form", evaluation_form}},
                             plan.options.engine),
       .outputs =
           [&] {
             return hashes_of({json_file, csv_file});
           },
       .work =
           [&](const ProgressCallback& progress) {
             const evaluation::Evaluated judged = evaluated(plan, models, set, progress);
             write_whole(csv_file, results::cells_csv(judged.cells));
             write_json(json_file, judged.evaluation);
           }});
  evaluations.push_back({set.name, models, json_file, csv_file});
}

/// By the run's truth if it is simulated, else by its labels.
bool has_press_and_slip(const RunFolder& run) {
  const evaluation::RunTruth truth = evaluation::read_run_truth(run);
  const std::vector<TouchInterval> touches = truth.has_truth ? truth.true_ones : truth.used();
  const auto has = [&](Touch touch) {
    return std::any_of(touches.begin(), touches.end(), [touch](const TouchInterval& one) { return one.touch == touch; });
  };
  return has(Touch::press) && has(Touch::slip);
}

void predict(const StudyPlan& plan, const StudyModel& model, std::uint32_t run_index, const fs::path& csv_file,
             const fs::path& json_file, const ProgressCallback& progress) {
  const windows::Dataset& dataset = plan.dataset;
  windows::check_unchanged(dataset, run_index);
  const windows::DatasetRun& run = dataset.runs()[run_index];
  const model::Classifier classifier = model::open_classifier(model.bundle.folder, plan.options.threads, plan.options.engine);
  const RunFolder folder{dataset.run_folder(run_index), run.object, run.run};
  std::map<CameraTime, Touch> samples;
  for (const windows::Sample& sample : dataset.samples()) {
    if (sample.run_index == run_index) samples[sample.t] = sample.touch;
  }
  const std::size_t total = evaluation::expected_ticks(folder.events(), classifier.rendering());
  std::size_t done = 0;
  const auto prediction = evaluation::predict_run(
      folder, classifier, {.include_flagged = plan.options.include_flagged, .threads = plan.options.threads},
      [&](std::size_t ticks) {
        done += ticks;
        report_progress(progress, done, total, "every tick of " + name_of(run));
      });
  evaluation::write_prediction(csv_file, prediction, samples);
  write_json(json_file, evaluation::outcome_json(prediction));
}

void predict_full_run(const StudyPlan& plan, const StudyModel& model, experiments::StepRunner& runner, JudgedModels& judged) {
  const StudyOptions& options = plan.options;
  const std::vector<RunFolder> reported = evaluation::folders_of(plan.dataset, plan.trainings.front().reported.runs);
  const std::size_t place = run_to_show(reported);
  const std::uint32_t shown = plan.trainings.front().reported.runs[place];
  const RunFolder& run = reported[place];
  judged.full_run = run.name();
  judged.full_run_file = options.out / "runs" / (run.object + "-" + run.run + ".csv");
  const fs::path json_file = fs::path(judged.full_run_file).replace_extension(".json");
  runner.run(
      {.name = "run-" + run.object + "-" + run.run,
       .command = experiments::command_of({"eval", options.data.string(), "--run", judged.full_run, "--models",
                                           options.models.string(), "--model", model.name(), "--out",
                                           (options.out / "runs").string(), "--engine", std::string(name_of(options.engine))}),
       .inputs = with_engine({{"manifest", plan.dataset.manifest_hash()},
                              {"weights", model::read_description(model.bundle).weights_sha256},
                              {"form", run_form},
                              {"truth", experiments::truth_hashes({run})}},
                             options.engine),
       .outputs =
           [&] {
             return hashes_of({judged.full_run_file, json_file});
           },
       .work =
           [&](const ProgressCallback& progress) { predict(plan, model, shown, judged.full_run_file, json_file, progress); }});
}

}  // namespace

std::size_t run_to_show(const std::vector<RunFolder>& runs) {
  std::vector<std::size_t> order(runs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return runs[i].object == "water-bottle"; });
  const auto shown = std::find_if(order.begin(), order.end(), [&](std::size_t i) { return has_press_and_slip(runs[i]); });
  return shown == order.end() ? order.front() : *shown;
}

const EvaluatedModels& JudgedModels::evaluation(const std::string& id) const {
  return *std::find_if(evaluations.begin(), evaluations.end(), [&](const EvaluatedModels& one) { return one.id == id; });
}

JudgedModels judge_models(const StudyPlan& plan, const TrainedModels& trained, experiments::StepRunner& runner) {
  JudgedModels judged;
  std::vector<StudyModel> reported;
  for (std::size_t training = 0; training < plan.trainings.size(); ++training) reported.push_back(trained.reported(training));
  evaluate_on(plan, reported, run_sets[1], runner, judged.evaluations);
  evaluate_on(plan, trained.by_history.at(trained.paper_history), run_sets[2], runner, judged.evaluations);
  predict_full_run(plan, reported.front(), runner, judged);
  return judged;
}

std::vector<results::RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where) {
  std::vector<results::RunDetections> runs;
  for (const results::JsonView& run : results::JsonView(evaluation, where, results::MissingMember::is_error)["runs"].items())
    runs.push_back(results::detections_in(run));
  return runs;
}

std::map<std::string, bool> detected_at_first_tick(const std::map<std::string, results::DelaySummary>& delays, double tick_ms) {
  std::map<std::string, bool> at_first_tick;
  for (const auto& [object, delay] : delays) {
    if (delay.intervals > 0)
      at_first_tick[object] = delay.misses + delay.early == 0 && delay.mean_ms.value <= tick_ms * (1 + 1e-9);
  }
  return at_first_tick;
}

}  // namespace tactile::study
