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

namespace tactile::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string path_in(const StudyPlan& plan, const fs::path& path) { return experiments::from_folder(path, plan.options.out); }

json training_json(const StudyPlan& plan, const StudyModel& model) {
  return {{"seed", model.settings.training.seed},
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
      one["accuracy"] = evaluation::accuracy_of(confusions_of(plan, {model}, plan.reported.names)).mean;
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
      " The mean over objects is higher at {} ms there, {:.2f} % against {:.2f} %; the paper's rule decides: the history that is "
      "best for the most objects; only among equals, the highest mean.",
      experiments::ms_text(best->first), 100 * best->second.mean.value, 100 * chosen);
}

json choice_json(const StudyPlan& plan, const TrainedModels& trained) {
  const bool chosen_on_runs = !plan.choice.runs.empty();
  json choice = {{"th_ms", in_ms(trained.history)},
                 {"model", trained.chosen().name()},
                 {"chosen_on", chosen_on_runs ? "choice" : "default"},
                 {"best", {{"choice", nullptr}}}};
  if (chosen_on_runs) {
    const HistoryComparison& comparison = trained.comparisons.at("choice");
    choice["why"] = fmt::format("{} ms is the best history for {} of {} objects on the runs to choose on ({}).{}",
                                experiments::ms_text(trained.history), comparison.choice.counts.at(trained.history),
                                comparison.choice.of_objects.size(),
                                fmt::join(preset_settings(plan.options.preset).choice_runs, ", "), rule_of(comparison));
  } else {
    choice["why"] = fmt::format("No run is left to choose a history on beside those reported on, so t_h stays {} ms.",
                                experiments::ms_text(trained.history));
  }
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

json evaluation_json(const StudyPlan& plan, const EvaluatedModel& evaluated) {
  const json full = read_json(evaluated.json_file);
  const results::JsonView view(full, evaluated.json_file.string(), results::MissingMember::is_error);
  json entry = {{"id", evaluated.id},
                {"th_ms", in_ms(evaluated.model.settings.rendering.history)},
                {"seed", evaluated.model.settings.training.seed},
                {"model", evaluated.model.name()},
                {"runs", evaluated.runs},
                {"json", path_in(plan, evaluated.json_file)},
                {"csv", path_in(plan, evaluated.csv_file)}};
  for (const char* key : {"accuracy", "confusion", "accuracy_by_guard", "delay_ms", "false_alarms_per_min", "over_time"})
    entry[key] = full.at(key);
  entry["slip_at_once"]["objects"] =
      detected_at_first_tick(view["delay_ms"]["slip"].get<results::DelayTable>().objects, view["tick_ms"].number());
  return entry;
}

json settings_json(const StudyPlan& plan, bool simulated) {
  const StudyOptions& options = plan.options;
  std::vector<std::uint64_t> seeds;
  for (unsigned training = 0; training < options.seeds; ++training) seeds.push_back(plan.seed_of(training));
  json histories = json::array();
  for (const microseconds history : options.histories) histories.push_back(in_ms(history));
  return {{"data", path_in(plan, options.data)},
          {"models", path_in(plan, options.models)},
          {"preset", options.preset},
          {"seed", options.seed},
          {"seeds", seeds},
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

/// What confidence intervals include, and what they do not.
std::string sentence_on_trainings(unsigned seeds) {
  if (seeds == 1) return "One training each: intervals are over runs and objects, and do not include the effect of another seed.";
  return fmt::format(
      "{} trainings each: their verdicts are counted together, delays are those of the first. Intervals are over runs and "
      "objects, and do not include the effect of other seeds. The table of models has the accuracy of each training.",
      seeds);
}

/// All but objects held out and claims.
json study_json(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged, const PreparedData& prepared,
                std::span<const experiments::StepRecord> steps) {
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
                  {"trainings", sentence_on_trainings(plan.options.seeds)}}},
                {"steps", experiments::steps_json(steps)},
                {"dataset",
                 {{"file", path_in(plan, prepared.dataset)},
                  {"manifest_hash", dataset.manifest_hash()},
                  {"samples", dataset.samples().size()},
                  {"tick_ms", in_ms(dataset.sampling().tick)},
                  {"guard_ms", in_ms(dataset.sampling().guard)}}},
                {"runs", {{"train", names_of(dataset, plan.train)}}},
                {"histories", histories_json(plan, trained)},
                {"choice", choice_json(plan, trained)},
                {"paper_way", paper_way_json(trained)},
                {"evaluations", json::array()},
                {"full_runs", json::array({json{{"run", judged.full_run},
                                                {"model", trained.chosen().name()},
                                                {"th_ms", in_ms(trained.history)},
                                                {"csv", path_in(plan, judged.full_run_file)}}})},
                {"unseen", nullptr},
                {"splits", json::array()},
                {"splits_mean", nullptr},
                {"remarks", plan.remarks}};
  for (const EvaluatedModel& evaluated : judged.evaluations) study["evaluations"].push_back(evaluation_json(plan, evaluated));
  for (const RunSet* set : plan.run_sets()) study["runs"][set->name] = set->names;
  study["left_out"] = left_out_of(dataset, is_there(plan.options.data) ? find_runs(plan.options.data) : std::vector<RunFolder>{});
  return study;
}

/// Accuracy on held-out objects: of models trained without them, and of as many models of the same seeds trained with them.
/// @param held_out  models trained without the same objects, one at least
/// @return  without runs, if the set has none of these objects
results::UnseenComparison compared_on(const StudyPlan& plan, const TrainedModels& trained,
                                      const std::vector<StudyModel>& held_out, const RunSet& set) {
  std::vector<std::string> runs;
  const std::vector<std::uint32_t>& judged_on = held_out.front().runs;
  for (std::size_t i = 0; i < set.runs.size(); ++i) {
    if (std::find(judged_on.begin(), judged_on.end(), set.runs[i]) != judged_on.end()) runs.push_back(set.names[i]);
  }
  if (runs.empty()) return {};
  std::vector<StudyModel> seen = trained.by_history.at(trained.history);
  seen.erase(seen.begin() + static_cast<std::ptrdiff_t>(std::min(seen.size(), held_out.size())), seen.end());
  results::UnseenComparison comparison =
      evaluation::unseen_comparison(confusions_of(plan, seen, runs), confusions_of(plan, held_out, runs));
  comparison.runs = std::move(runs);
  return comparison;
}

/// The loss of accuracy over all drawn splits: an object's runs count once for each split that holds it out.
/// @return  nothing if the set has no run of a held-out object
std::optional<results::Figure> mean_difference_of_splits(const StudyPlan& plan, const TrainedModels& trained, const RunSet& set) {
  std::map<std::string, results::RunConfusion> seen_in, held_out_in;  // by run
  for (const StudyModel& model : trained.splits) {
    const results::UnseenComparison comparison = compared_on(plan, trained, {model}, set);
    if (comparison.runs.empty()) continue;
    const auto seen = confusions_of(plan, {trained.chosen()}, comparison.runs);
    const auto held_out = confusions_of(plan, {model}, comparison.runs);
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
      const std::string& run = comparison.runs[i];
      seen_in[run].object = held_out_in[run].object = seen[i].object;
      seen_in[run].confusion += seen[i].confusion;
      held_out_in[run].confusion += held_out[i].confusion;
    }
  }
  if (seen_in.empty()) return std::nullopt;
  std::vector<results::RunConfusion> seen, held_out;
  for (const auto& [run, confusion] : seen_in) {
    seen.push_back(confusion);
    held_out.push_back(held_out_in.at(run));
  }
  return evaluation::accuracy_difference(seen, held_out).mean;
}

/// Adds "unseen", "splits" and "splits_mean" to study.json, and the rows of unseen.csv.
void add_unseen_objects(const StudyPlan& plan, const TrainedModels& trained, StudyResults& results) {
  json& study = results.study;
  const auto add_comparison = [&](json& entry, const std::string& split, const std::vector<StudyModel>& held_out) {
    for (const RunSet* set : {&plan.reported, &plan.all_test}) {
      const results::UnseenComparison comparison = compared_on(plan, trained, held_out, *set);
      entry[set->name] = comparison.runs.empty() ? json() : json(comparison);
      if (!comparison.runs.empty()) results.unseen.push_back({split, set->name, comparison});
    }
  };
  if (!trained.held_out.empty()) {
    json& unseen =
        study["unseen"] = {{"th_ms", in_ms(trained.history)},
                           {"held_out", plan.held_out},
                           {"models", {{"seen", trained.chosen().name()}, {"held_out", trained.held_out.front().name()}}}};
    for (const StudyModel& model : trained.held_out) unseen["trainings"].push_back(training_json(plan, model));
    add_comparison(unseen, "paper", trained.held_out);
  }
  for (std::size_t i = 0; i < plan.splits.size(); ++i) {
    const StudyModel& model = trained.splits[i];
    json split = {{"name", plan.splits[i].name},
                  {"held_out", plan.splits[i].held_out},
                  {"model", model.name()},
                  {"training", training_json(plan, model)}};
    add_comparison(split, plan.splits[i].name, {model});
    study["splits"].push_back(split);
  }
  for (const RunSet* set : {&plan.reported, &plan.all_test}) {
    if (plan.splits.empty()) break;
    const std::optional<results::Figure> mean = mean_difference_of_splits(plan, trained, *set);
    study["splits_mean"][set->name] = mean ? json(*mean) : json();
  }
}

std::vector<results::Claim> claims_on(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                                      const RunSet& set) {
  const EvaluatedModel& evaluated = judged.evaluation(set.name);
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
  inputs.history_ms = in_ms(evaluated.model.settings.rendering.history);
  inputs.over_time = over_time["both"].get<results::ShareOverTime>();
  inputs.after_ms = over_time["after_ms"].number();
  if (!trained.held_out.empty()) {
    const std::vector<std::string> runs = compared_on(plan, trained, trained.held_out, set).runs;
    inputs.seen = confusions_of(plan, trained.by_history.at(trained.history), runs);
    inputs.held_out = confusions_of(plan, trained.held_out, runs);
  }
  return claims_of(inputs);
}

}  // namespace

StudyResults results_of(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                        const PreparedData& prepared, std::span<const experiments::StepRecord> steps) {
  StudyResults results;
  results.study = study_json(plan, trained, judged, prepared, steps);
  add_unseen_objects(plan, trained, results);
  results.claims = claims_on(plan, trained, judged, plan.reported);
  const std::vector<results::Claim> on_all_test_runs = claims_on(plan, trained, judged, plan.all_test);
  for (std::size_t i = 0; i < results.claims.size(); ++i)
    results.claims[i].all_test = static_cast<const results::ClaimOutcome&>(on_all_test_runs[i]);
  results.study["claims"] = results.claims;
  results.study["summary"] = summary_of(results.claims, plan.dataset.simulated());
  for (const RunSet* set : plan.run_sets()) {
    if (set->runs.empty()) continue;
    for (const auto& [history, accuracy] : trained.comparisons.at(set->name).accuracies)
      results.accuracy.push_back({in_ms(history), set->name, &accuracy});
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
