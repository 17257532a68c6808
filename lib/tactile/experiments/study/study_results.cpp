#include "tactile/experiments/study/study_results.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "tactile/core/json.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/study/claims.hpp"
#include "tactile/experiments/study/left_out.hpp"
#include "tactile/experiments/study/study_tables.hpp"
#include "tactile/results/found.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string path_in(const StudyPlan& plan, const fs::path& path) { return experiments::from_folder(path, plan.options.out); }

results::TrainedModel described(const StudyPlan& plan, const StudyModel& model) {
  return {.training = model.training,
          .seed = model.settings.training.seed,
          .history_ms = in_ms(model.settings.rendering.history),
          .name = model.name(),
          .folder = path_in(plan, model.bundle.folder),
          .history = path_in(plan, model.bundle.history()),
          .samples = path_in(plan, samples_file(plan, model)),
          .weights_sha256 = model::read_description(model.bundle).weights_sha256};
}

std::vector<results::TrainedModel> described(const StudyPlan& plan, const std::vector<StudyModel>& models) {
  std::vector<results::TrainedModel> all;
  all.reserve(models.size());
  for (const StudyModel& model : models) all.push_back(described(plan, model));
  return all;
}

/// On the runs that the model's training reports on.
results::Accuracy reported_accuracy(const StudyPlan& plan, const StudyModel& model) {
  return evaluation::accuracy_of(confusions_of(plan, model, plan.trainings[model.training].reported.names));
}

std::vector<results::StudyHistory> histories_of(const StudyPlan& plan, const TrainedModels& trained) {
  std::vector<results::StudyHistory> histories;
  for (const auto& [history, models] : trained.by_history) {
    results::StudyHistory one{.history_ms = in_ms(history), .models = described(plan, models)};
    for (std::size_t i = 0; i < models.size(); ++i) one.models[i].accuracy = reported_accuracy(plan, models[i]).mean;
    for (const auto& [set, comparison] : trained.comparisons) one.accuracy[set] = comparison.accuracies.at(history);
    histories.push_back(std::move(one));
  }
  return histories;
}

/// How the rule decided, where another history has a higher mean.
std::string rule_of(const HistoryComparison& comparison) {
  const AccuracyByHistory& accuracies = comparison.accuracies;
  const auto best = std::max_element(accuracies.begin(), accuracies.end(),
                                     [](const auto& a, const auto& b) { return a.second.mean.value < b.second.mean.value; });
  const double chosen = accuracies.at(comparison.choice.history).mean.value;
  if (!(best->second.mean.value > chosen)) return " The mean over objects is the highest there, too.";
  return fmt::format(
      " The mean over objects is higher at {} ms there, {:.2f} % against {:.2f} %. But the paper's rule decides: the history "
      "that is best for most objects; among equals, the one with the highest mean.",
      experiments::ms_text(best->first), 100 * best->second.mean.value, 100 * chosen);
}

/// "40 ms is the best history for 5 of 10 objects on …", and how the rule decided.
std::string why_best(microseconds history, const HistoryComparison& comparison, const char* runs) {
  return fmt::format("{} ms is the best history for {} of {} objects on {}.{}", experiments::ms_text(history),
                     comparison.choice.counts.at(history), comparison.choice.of_objects.size(), runs, rule_of(comparison));
}

results::StudyChoice choice_of(const StudyPlan& plan, const TrainedModels& trained) {
  results::StudyChoice choice;
  choice.history_ms = in_ms(trained.history);
  choice.model = trained.to_use().name();
  choice.chosen_on = plan.has_choice() ? "choice" : "default";
  choice.why = plan.has_choice()
                   ? why_best(trained.history, trained.comparisons.at("choice"), "the runs to choose on")
                   : fmt::format("No run is left to choose a history on besides those reported on, so t_h stays {} ms.",
                                 experiments::ms_text(trained.history));
  for (const microseconds history : trained.chosen) choice.trainings.push_back(in_ms(history));
  for (const auto& [set, comparison] : trained.comparisons) choice.best[set] = comparison.choice;
  return choice;
}

results::ChosenHistory paper_way(const TrainedModels& trained) {
  const microseconds history = trained.paper_history;
  return {.history_ms = in_ms(history),
          .model = trained.by_history.at(history).front().name(),
          .why = why_best(history, trained.comparisons.at("all_test"), "all test runs, which are also reported on")};
}

results::StudyEvaluation evaluation_of(const StudyPlan& plan, const EvaluatedModels& evaluated) {
  const json full = read_json(evaluated.json_file);
  const results::JsonView view(full, evaluated.json_file.string(), results::MissingMember::is_error);
  results::StudyEvaluation evaluation{.id = evaluated.id,
                                      .models = described(plan, evaluated.models),
                                      .runs = evaluated.id,
                                      .json_file = path_in(plan, evaluated.json_file),
                                      .csv_file = path_in(plan, evaluated.csv_file)};
  for (const char* key : results::evaluation_figures) evaluation.figures[key] = full.at(key);
  evaluation.slip_at_once =
      detected_at_first_tick(view["delay_ms"]["slip"].get<results::DelayTable>().objects, view["tick_ms"].number());
  return evaluation;
}

json settings_json(const StudyPlan& plan, bool simulated) {
  const StudyOptions& options = plan.options;
  json histories = json::array();
  for (const microseconds history : options.histories) histories.push_back(in_ms(history));
  return {{"data", path_in(plan, options.data)},
          {"models", path_in(plan, options.models)},
          {"preset", options.preset},
          {"seed", options.seed},
          {"trainings", plan.trainings.size()},
          {"train_run", options.train_run},
          {"held_out", plan.held_out},
          {"histories_ms", histories},
          {"epochs", *options.epochs},
          {"engine", name_of(options.engine)},
          {"include_flagged", options.include_flagged},
          {"splits", plan.splits.size()},
          {"objects", simulated && !options.objects.empty() ? json(options.objects) : json()},
          {"runs", simulated && options.runs ? json(*options.runs) : json()}};
}

/// What each training learned from and is judged on.
std::vector<results::StudyTraining> trainings_of(const StudyPlan& plan, const TrainedModels& trained) {
  std::vector<results::StudyTraining> trainings;
  for (std::size_t k = 0; k < plan.trainings.size(); ++k) {
    const PlannedTraining& training = plan.trainings[k];
    trainings.push_back({.seed = training.seed,
                         .train_run = training.train_run,
                         .history_ms = in_ms(trained.chosen[k]),
                         .train = training.train.names,
                         .choice = training.choice.names,
                         .reported = training.reported.names,
                         .all_test = training.all_test.names});
  }
  return trainings;
}

/// What confidence intervals include, and what they do not.
std::string sentence_on_trainings(std::size_t trainings) {
  if (trainings == 1) return "One training of each setting: intervals are over runs and objects, not over trainings.";
  if (trainings == 2) return "Two trainings give no intervals: take three or more.";
  return fmt::format(
      "{} trainings of each setting, each on another run and with another seed. Each is judged on runs that it neither learned "
      "from nor was chosen on. Intervals are over trainings, objects and runs.",
      trainings);
}

/// Where the variance of the reported accuracy comes from; nothing where it cannot be divided.
std::optional<results::VarianceShares> variance_of(const StudyPlan& plan, const TrainedModels& trained) {
  std::vector<results::RunConfusion> reported;
  for (std::size_t training = 0; training < plan.trainings.size(); ++training) {
    const auto of_training = confusions_of(plan, trained.reported(training), plan.trainings[training].reported.names);
    reported.insert(reported.end(), of_training.begin(), of_training.end());
  }
  // Where no run is judged by two trainings, trainings and runs cannot be distinguished.
  std::map<std::pair<std::string, std::string>, std::size_t> judged;
  std::size_t most = 0;
  for (const results::RunConfusion& run : reported) most = std::max(most, ++judged[{run.object, run.run}]);
  return most < 2 ? std::nullopt : evaluation::variance_of_accuracy(reported);
}

/// All trainings with the chosen history.
results::TrainingSpread training_spread(const StudyPlan& plan, const TrainedModels& trained) {
  results::TrainingSpread spread{.history_ms = in_ms(trained.history)};
  for (const StudyModel& model : trained.by_history.at(trained.history)) {
    const results::Accuracy accuracy = reported_accuracy(plan, model);
    if (accuracy.objects.empty()) continue;
    spread.mean.push_back(accuracy.mean.value);
    for (const auto& [object, figure] : accuracy.objects) spread.objects[object].push_back(figure.value);
  }
  return spread;
}

/// All but objects held out and claims.
results::Study study_without_claims(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                                    const PreparedData& prepared, std::span<const results::StepRecord> steps) {
  const windows::Dataset& dataset = plan.dataset;
  results::Study study{
      .title = fmt::format("The paper's study on {} runs ({})", dataset.simulated() ? "simulated" : "real", plan.options.preset),
      .simulated = dataset.simulated(),
      .settings = settings_json(plan, prepared.simulated),
      .software = experiments::software_json(),
      .machine = experiments::machine_json(plan.options.threads),
      .bootstrap = {{}, sentence_on_trainings(plan.trainings.size())},
      .steps = {steps.begin(), steps.end()},
      .dataset = {.file = path_in(plan, prepared.dataset),
                  .manifest_hash = dataset.manifest_hash(),
                  .samples = dataset.samples().size(),
                  .tick_ms = in_ms(dataset.sampling().tick),
                  .guard_ms = in_ms(dataset.sampling().guard)},
      .trainings = trainings_of(plan, trained),
      .histories = histories_of(plan, trained),
      .choice = choice_of(plan, trained),
      .paper_way = paper_way(trained),
      .variance = variance_of(plan, trained),
      .training_spread = training_spread(plan, trained),
      .full_runs = {{.run = judged.full_run,
                     .model = trained.reported(0).name(),
                     .history_ms = in_ms(trained.chosen.front()),
                     .csv = path_in(plan, judged.full_run_file)}},
      .remarks = plan.remarks};
  for (const EvaluatedModels& evaluated : judged.evaluations) study.evaluations.push_back(evaluation_of(plan, evaluated));
  study.left_out = left_out_of(dataset, is_there(plan.options.data) ? find_runs(plan.options.data) : std::vector<RunFolder>{});
  return study;
}

/// The sets of runs that results are reported on.
std::span<const NamedRunSet> judged_sets() { return std::span(run_sets).subspan(1); }

/// Verdicts on the same runs of held-out objects: of models trained without them, and of the same trainings with them.
struct SeenAndUnseen {
  std::vector<results::RunConfusion> seen, held_out;
  std::vector<std::string> runs;  ///< each once, by name

  bool empty() const { return runs.empty(); }
};

SeenAndUnseen judged_on(const StudyPlan& plan, const TrainedModels& trained, const std::vector<StudyModel>& held_out,
                        const NamedRunSet& set) {
  SeenAndUnseen judged;
  const auto add = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
  for (const StudyModel& model : held_out) {
    const RunSet& of_training = plan.trainings[model.training].*set.runs;
    std::vector<std::string> runs;
    for (std::size_t i = 0; i < of_training.runs.size(); ++i) {
      if (std::find(model.runs.begin(), model.runs.end(), of_training.runs[i]) != model.runs.end())
        runs.push_back(of_training.names[i]);
    }
    add(judged.seen, confusions_of(plan, trained.by_history.at(model.settings.rendering.history)[model.training], runs));
    add(judged.held_out, confusions_of(plan, model, runs));
    add(judged.runs, runs);
  }
  std::sort(judged.runs.begin(), judged.runs.end());
  judged.runs.erase(std::unique(judged.runs.begin(), judged.runs.end()), judged.runs.end());
  return judged;
}

/// Of all sets of objects that the plan holds out.
std::vector<StudyModel> all_held_out(const TrainedModels& trained) {
  std::vector<StudyModel> all;
  for (const auto& models : trained.held_out) all.insert(all.end(), models.begin(), models.end());
  return all;
}

/// Nothing on a set without a run of the held-out objects.
results::OnRunSets<results::UnseenComparison> compared_with_seen(const StudyPlan& plan, const TrainedModels& trained,
                                                                 const std::vector<StudyModel>& held_out) {
  results::OnRunSets<results::UnseenComparison> on;
  for (const NamedRunSet& set : judged_sets()) {
    const SeenAndUnseen judged = judged_on(plan, trained, held_out, set);
    if (judged.empty()) continue;
    on[set.name] = evaluation::unseen_comparison(judged.seen, judged.held_out);
    on[set.name]->runs = judged.runs;
  }
  return on;
}

/// Adds what is held out by the plan and by the drawn splits.
void add_unseen_objects(const StudyPlan& plan, const TrainedModels& trained, results::Study& study) {
  if (const std::vector<StudyModel> models = all_held_out(trained); !models.empty()) {
    const StudyModel& first = models.front();
    study.unseen = {.held_out = plan.held_out,
                    .models = {trained.by_history.at(first.settings.rendering.history)[first.training].name(), first.name()},
                    .trainings = described(plan, models),
                    .on = compared_with_seen(plan, trained, models)};
  }
  for (std::size_t i = 0; i < plan.splits.size(); ++i) {
    const StudyModel& model = trained.splits[i];
    study.splits.push_back({.name = plan.splits[i].name,
                            .held_out = plan.splits[i].held_out,
                            .model = model.name(),
                            .training = described(plan, model),
                            .on = compared_with_seen(plan, trained, {model})});
  }
  for (const NamedRunSet& set : judged_sets()) {
    const SeenAndUnseen all = judged_on(plan, trained, trained.splits, set);
    if (!all.empty()) study.splits_mean[set.name] = evaluation::accuracy_difference(all.seen, all.held_out).mean;
  }
}

results::Evaluation evaluation_in(const EvaluatedModels& evaluated) {
  const json full = read_json(evaluated.json_file);
  return results::JsonView(full, evaluated.json_file.string(), results::MissingMember::is_error).get<results::Evaluation>();
}

std::vector<results::Claim> claims_on(const TrainedModels& trained, const JudgedModels& judged, const NamedRunSet& set,
                                      const SeenAndUnseen& objects) {
  const EvaluatedModels& evaluated = judged.evaluation(set.name);
  const std::string where = evaluated.json_file.string();
  const json evaluation = read_json(evaluated.json_file);
  const results::JsonView over_time = results::JsonView(evaluation, where, results::MissingMember::is_error)["over_time"];
  ClaimInputs inputs;
  inputs.histories = trained.comparisons.at(set.name).confusions;
  for (const microseconds history : StudyOptions{}.histories) {
    if (!inputs.histories.contains(history)) inputs.untrained.push_back(history);
  }
  inputs.detections = detections_in(evaluation, where);
  inputs.tick_ms = member<double>(evaluation, "tick_ms", where);
  inputs.history_ms = in_ms(set.runs == &PlannedTraining::all_test ? trained.paper_history : trained.history);
  inputs.over_time = over_time["both"].get<results::ShareOverTime>();
  inputs.after_ms = over_time["after_ms"].number();
  inputs.seen = objects.seen;
  inputs.held_out = objects.held_out;
  return claims_of(inputs);
}

}  // namespace

results::Study results_of(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                          const PreparedData& prepared, std::span<const results::StepRecord> steps) {
  results::Study study = study_without_claims(plan, trained, judged, prepared, steps);
  add_unseen_objects(plan, trained, study);
  const auto on = [&](const NamedRunSet& set) {
    return claims_on(trained, judged, set, judged_on(plan, trained, all_held_out(trained), set));
  };
  study.claims = on(run_sets[1]);
  const std::vector<results::Claim> on_all_test_runs = on(run_sets[2]);
  for (std::size_t i = 0; i < study.claims.size(); ++i)
    study.claims[i].all_test = static_cast<const results::ClaimOutcome&>(on_all_test_runs[i]);
  study.summary = summary_of(study.claims, plan.dataset.simulated());
  const std::optional<results::UnseenComparison> unseen = study.unseen ? study.unseen->on.reported : std::nullopt;
  study.found = results::found_in(evaluation_in(judged.evaluation("reported")), trained.chosen,
                                  unseen.value_or(results::UnseenComparison{}), study.summary);
  return study;
}

void write_results(const results::Study& study, const fs::path& folder) {
  const auto write_if_changed = [&](const char* name, const std::string& text) {
    if (!fs::exists(folder / name) || read_text(folder / name) != text) write_whole(folder / name, text);
  };
  write_if_changed("accuracy.csv", accuracy_csv(study.histories));
  write_if_changed("unseen.csv", unseen_csv(study));
  write_if_changed("claims.csv", claims_csv(study.claims));
  write_if_changed("study.json", json_text(study, 2) + "\n");
}

}  // namespace tactile::study
