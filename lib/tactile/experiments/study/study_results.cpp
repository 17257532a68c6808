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
#include "tactile/experiments/study/training_spread.hpp"
#include "tactile/results/found.hpp"

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string path_in(const StudyPlan& plan, const fs::path& path) { return experiments::from_folder(path, plan.options.out); }

json training_json(const StudyPlan& plan, const StudyModel& model) {
  return {{"training", model.training},
          {"seed", model.settings.training.seed},
          {"th_ms", in_ms(model.settings.rendering.history)},
          {"name", model.name()},
          {"folder", path_in(plan, model.bundle.folder)},
          {"history", path_in(plan, model.bundle.history())},
          {"weights_sha256", model::read_description(model.bundle).weights_sha256},
          {"samples", path_in(plan, samples_file(plan, model))}};
}

json histories_json(const StudyPlan& plan, const TrainedModels& trained) {
  json histories = json::array();
  for (const auto& [history, models] : trained.by_history) {
    json entry = {{"th_ms", in_ms(history)}, {"models", json::array()}, {"accuracy", {{"choice", nullptr}}}};
    for (const StudyModel& model : models) {
      json one = training_json(plan, model);
      one["accuracy"] = evaluation::accuracy_of(confusions_of(plan, model, plan.trainings[model.training].reported.names)).mean;
      entry["models"].push_back(one);
    }
    for (const auto& [set, comparison] : trained.comparisons) entry["accuracy"][set] = comparison.accuracies.at(history);
    histories.push_back(entry);
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

json choice_json(const StudyPlan& plan, const TrainedModels& trained) {
  json choice = {{"th_ms", in_ms(trained.history)},
                 {"model", trained.to_use().name()},
                 {"chosen_on", plan.has_choice() ? "choice" : "default"},
                 {"trainings", json::array()},
                 {"best", {{"choice", nullptr}}}};
  if (plan.has_choice()) {
    const HistoryComparison& comparison = trained.comparisons.at("choice");
    choice["why"] = fmt::format("{} ms is the best history for {} of {} objects on the runs to choose on.{}",
                                experiments::ms_text(trained.history), comparison.choice.counts.at(trained.history),
                                comparison.choice.of_objects.size(), rule_of(comparison));
  } else {
    choice["why"] = fmt::format("No run is left to choose a history on besides those reported on, so t_h stays {} ms.",
                                experiments::ms_text(trained.history));
  }
  for (const microseconds history : trained.chosen) choice["trainings"].push_back(in_ms(history));
  for (const auto& [set, comparison] : trained.comparisons) choice["best"][set] = comparison.choice;
  return choice;
}

json paper_way_json(const TrainedModels& trained) {
  const microseconds history = trained.paper_history;
  const HistoryComparison& comparison = trained.comparisons.at("all_test");
  return {{"th_ms", in_ms(history)},
          {"model", trained.by_history.at(history).front().name()},
          {"why", fmt::format("{} ms is the best history for {} of {} objects on all test runs, which are also reported on.{}",
                              experiments::ms_text(history), comparison.choice.counts.at(history),
                              comparison.choice.of_objects.size(), rule_of(comparison))}};
}

json evaluation_json(const StudyPlan& plan, const EvaluatedModels& evaluated) {
  const json full = read_json(evaluated.json_file);
  const results::JsonView view(full, evaluated.json_file.string(), results::MissingMember::is_error);
  json entry = {{"id", evaluated.id},
                {"models", json::array()},
                {"runs", evaluated.id},
                {"json", path_in(plan, evaluated.json_file)},
                {"csv", path_in(plan, evaluated.csv_file)}};
  for (const StudyModel& model : evaluated.models) entry["models"].push_back(training_json(plan, model));
  for (const char* key : {"accuracy", "confusion", "accuracy_by_guard", "delay_ms", "false_alarms_per_min", "over_time"})
    entry[key] = full.at(key);
  entry["slip_at_once"]["objects"] =
      detected_at_first_tick(view["delay_ms"]["slip"].get<results::DelayTable>().objects, view["tick_ms"].number());
  return entry;
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
json trainings_json(const StudyPlan& plan, const TrainedModels& trained) {
  json trainings = json::array();
  for (std::size_t k = 0; k < plan.trainings.size(); ++k) {
    const PlannedTraining& training = plan.trainings[k];
    json one = {{"seed", training.seed}, {"train_run", training.train_run}, {"th_ms", in_ms(trained.chosen[k])}};
    one["runs"]["train"] = training.train.names;
    for (const NamedRunSet& set : run_sets) one["runs"][set.name] = (training.*set.runs).names;
    trainings.push_back(one);
  }
  return trainings;
}

/// What confidence intervals include, and what they do not.
std::string sentence_on_trainings(std::size_t trainings) {
  if (trainings == 1) return "One training of each setting: intervals are over runs and objects, not over trainings.";
  return fmt::format(
      "{} trainings of each setting, each on another run and with another seed. Each is judged on runs that it neither learned "
      "from "
      "nor was chosen on. Intervals are over trainings, objects and runs.",
      trainings);
}

/// Where the variance of the reported accuracy comes from; null where it cannot be divided.
json variance_json(const StudyPlan& plan, const TrainedModels& trained) {
  std::vector<results::RunConfusion> reported;
  for (std::size_t training = 0; training < plan.trainings.size(); ++training) {
    const auto of_training = confusions_of(plan, trained.reported(training), plan.trainings[training].reported.names);
    reported.insert(reported.end(), of_training.begin(), of_training.end());
  }
  const auto shares = evaluation::variance_of_accuracy(reported);
  // Where no run is judged by two trainings, trainings and runs cannot be distinguished.
  std::map<std::pair<std::string, std::string>, std::size_t> judged;
  std::size_t most = 0;
  for (const results::RunConfusion& run : reported) most = std::max(most, ++judged[{run.object, run.run}]);
  if (!shares || most < 2) return {};
  return *shares;
}

/// All trainings with the chosen history.
TrainingSpread training_spread(const StudyPlan& plan, const TrainedModels& trained) {
  TrainingSpread spread{.history_ms = in_ms(trained.history), .mean = {}, .objects = {}};
  for (const StudyModel& model : trained.by_history.at(trained.history)) {
    const results::Accuracy accuracy =
        evaluation::accuracy_of(confusions_of(plan, model, plan.trainings[model.training].reported.names));
    if (accuracy.objects.empty()) continue;
    spread.mean.push_back(accuracy.mean.value);
    for (const auto& [object, figure] : accuracy.objects) spread.objects[object].push_back(figure.value);
  }
  return spread;
}

/// All but objects held out and claims.
json study_json(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged, const PreparedData& prepared,
                std::span<const results::StepRecord> steps) {
  const windows::Dataset& dataset = plan.dataset;
  const results::BootstrapOptions bootstrap;
  json study = {{"format", "tactile-study-1"},
                {"title", fmt::format("The paper's study on {} runs ({})", dataset.simulated() ? "simulated" : "real",
                                      plan.options.preset)},
                {"simulated", dataset.simulated()},
                {"settings", settings_json(plan, prepared.simulated)},
                {"software", experiments::software_json()},
                {"machine", experiments::machine_json(plan.options.threads)},
                {"bootstrap",
                 {{"draws", bootstrap.draws},
                  {"confidence", bootstrap.confidence},
                  {"seed", bootstrap.seed},
                  {"trainings", sentence_on_trainings(plan.trainings.size())}}},
                {"steps", std::vector(steps.begin(), steps.end())},
                {"dataset",
                 {{"file", path_in(plan, prepared.dataset)},
                  {"manifest_hash", dataset.manifest_hash()},
                  {"samples", dataset.samples().size()},
                  {"tick_ms", in_ms(dataset.sampling().tick)},
                  {"guard_ms", in_ms(dataset.sampling().guard)}}},
                {"trainings", trainings_json(plan, trained)},
                {"histories", histories_json(plan, trained)},
                {"choice", choice_json(plan, trained)},
                {"paper_way", paper_way_json(trained)},
                {"variance", variance_json(plan, trained)},
                {"training_spread", training_spread(plan, trained)},
                {"evaluations", json::array()},
                {"full_runs", json::array({json{{"run", judged.full_run},
                                                {"model", trained.reported(0).name()},
                                                {"th_ms", in_ms(trained.chosen.front())},
                                                {"csv", path_in(plan, judged.full_run_file)}}})},
                {"unseen", nullptr},
                {"splits", json::array()},
                {"splits_mean", nullptr},
                {"remarks", plan.remarks}};
  for (const EvaluatedModels& evaluated : judged.evaluations) study["evaluations"].push_back(evaluation_json(plan, evaluated));
  study["left_out"] = left_out_of(dataset, is_there(plan.options.data) ? find_runs(plan.options.data) : std::vector<RunFolder>{});
  return study;
}

constexpr const char* split_of_plan = "paper";  // the name of the plan's own held-out objects in unseen.csv

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

/// @return  null if the set has no run of a held-out object
json comparison_json(const std::string& split, const SeenAndUnseen& judged, const NamedRunSet& set,
                     std::vector<UnseenRow>& rows) {
  if (judged.empty()) return {};
  results::UnseenComparison comparison = evaluation::unseen_comparison(judged.seen, judged.held_out);
  comparison.runs = judged.runs;
  rows.push_back({split, set.name, comparison});
  return comparison;
}

/// Adds "unseen", "splits" and "splits_mean" to study.json, and the rows of unseen.csv.
/// @param by_set  of the objects that the plan holds out, by the name of the set of runs
void add_unseen_objects(const StudyPlan& plan, const TrainedModels& trained, const std::map<std::string, SeenAndUnseen>& by_set,
                        StudyResults& results) {
  json& study = results.study;
  if (const std::vector<StudyModel> models = all_held_out(trained); !models.empty()) {
    const StudyModel& first = models.front();
    json& unseen = study["unseen"] = {
        {"held_out", plan.held_out},
        {"models",
         {{"seen", trained.by_history.at(first.settings.rendering.history)[first.training].name()}, {"held_out", first.name()}}}};
    for (const StudyModel& model : models) unseen["trainings"].push_back(training_json(plan, model));
    for (const NamedRunSet& set : judged_sets())
      unseen[set.name] = comparison_json(split_of_plan, by_set.at(set.name), set, results.unseen);
  }
  for (std::size_t i = 0; i < plan.splits.size(); ++i) {
    const StudyModel& model = trained.splits[i];
    json split = {{"name", plan.splits[i].name},
                  {"held_out", plan.splits[i].held_out},
                  {"model", model.name()},
                  {"training", training_json(plan, model)}};
    for (const NamedRunSet& set : judged_sets())
      split[set.name] = comparison_json(plan.splits[i].name, judged_on(plan, trained, {model}, set), set, results.unseen);
    study["splits"].push_back(split);
  }
  for (const NamedRunSet& set : judged_sets()) {
    if (plan.splits.empty()) break;
    const SeenAndUnseen all = judged_on(plan, trained, trained.splits, set);
    study["splits_mean"][set.name] = all.empty() ? json() : json(evaluation::accuracy_difference(all.seen, all.held_out).mean);
  }
}

results::Evaluation evaluation_in(const EvaluatedModels& evaluated) {
  const json full = read_json(evaluated.json_file);
  return results::JsonView(full, evaluated.json_file.string(), results::MissingMember::is_error).get<results::Evaluation>();
}

/// Of the objects that the plan holds out, as far as they are on the reported runs.
results::UnseenComparison unseen_on_reported(const std::vector<UnseenRow>& rows) {
  const auto found = std::find_if(
      rows.begin(), rows.end(), [](const UnseenRow& row) { return row.split == split_of_plan && row.runs == run_sets[1].name; });
  return found == rows.end() ? results::UnseenComparison{} : found->comparison;
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

StudyResults results_of(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                        const PreparedData& prepared, std::span<const results::StepRecord> steps) {
  StudyResults results;
  results.study = study_json(plan, trained, judged, prepared, steps);
  std::map<std::string, SeenAndUnseen> unseen;
  for (const NamedRunSet& set : judged_sets()) unseen[set.name] = judged_on(plan, trained, all_held_out(trained), set);
  add_unseen_objects(plan, trained, unseen, results);
  results.claims = claims_on(trained, judged, run_sets[1], unseen.at(run_sets[1].name));
  const std::vector<results::Claim> on_all_test_runs = claims_on(trained, judged, run_sets[2], unseen.at(run_sets[2].name));
  for (std::size_t i = 0; i < results.claims.size(); ++i)
    results.claims[i].all_test = static_cast<const results::ClaimOutcome&>(on_all_test_runs[i]);
  results.study["claims"] = results.claims;
  results.study["summary"] = summary_of(results.claims, plan.dataset.simulated());
  results.study["found"] = results::found_in(evaluation_in(judged.evaluation("reported")), trained.chosen,
                                             unseen_on_reported(results.unseen), results.study["summary"].get<std::string>());
  for (const NamedRunSet& set : run_sets) {
    const auto found = trained.comparisons.find(set.name);
    if (found == trained.comparisons.end()) continue;
    for (const auto& [history, accuracy] : found->second.accuracies)
      results.accuracy.push_back({in_ms(history), set.name, &accuracy});
  }
  return results;
}

void write_results(const StudyResults& results, const fs::path& folder) {
  const auto write_if_changed = [&](const char* name, const std::string& text) {
    if (!fs::exists(folder / name) || read_text(folder / name) != text) write_whole(folder / name, text);
  };
  write_if_changed("accuracy.csv", accuracy_csv(results.accuracy));
  write_if_changed("unseen.csv", unseen_csv(results.unseen));
  write_if_changed("claims.csv", claims_csv(results.claims));
  write_if_changed("study.json", json_text(results.study, 2) + "\n");
}

}  // namespace tactile::study
