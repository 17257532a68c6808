#include "tactile/results/study.hpp"

#include <fmt/core.h>

#include <cmath>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::results {
namespace {

constexpr const char* study_format = "tactile-study-1";

/// {"reported", "all_test"}
template <class T>
nlohmann::json judged_json(const OnRunSets<T>& on) {
  return {{"reported", json_or_null(on.reported)}, {"all_test", json_or_null(on.all_test)}};
}

/// {"choice", "reported", "all_test"}
template <class T>
nlohmann::json run_sets_json(const OnRunSets<T>& on) {
  nlohmann::json json = judged_json(on);
  json["choice"] = json_or_null(on.choice);
  return json;
}

template <class T>
OnRunSets<T> run_sets_in(const JsonView& json) {
  return {json["choice"].if_there<T>(), json["reported"].if_there<T>(), json["all_test"].if_there<T>()};
}

/// A history that is a key: "2.5"
microseconds history_named(const std::string& text, const JsonView& json) {
  const std::optional<double> ms = number_in(text);
  if (!ms || !(std::abs(*ms) < 1e9))
    throw Error(fmt::format("{} has the key '{}'; expected a history in ms", json.where(), text));
  return microseconds{std::llround(1000 * *ms)};
}

/// Of earlier versions a list of texts: one set.
std::vector<std::vector<std::string>> held_out_in(const JsonView& json) {
  std::vector<std::vector<std::string>> sets;
  for (const JsonView& set : json.items()) {
    if (set.is_text()) return {json.texts()};
    sets.push_back(set.texts());
  }
  return sets;
}

}  // namespace

void to_json(nlohmann::json& json, const StudyBootstrap& bootstrap) {
  json = static_cast<const BootstrapOptions&>(bootstrap);
  json["trainings"] = bootstrap.trainings;
}

void from_json(const JsonView& json, StudyBootstrap& bootstrap) {
  bootstrap = {json.get<BootstrapOptions>(), json["trainings"].text()};
}

void to_json(nlohmann::json& json, const StudyDataset& dataset) {
  json = {{"file", dataset.file},
          {"manifest_hash", dataset.manifest_hash},
          {"samples", dataset.samples},
          {"tick_ms", dataset.tick_ms},
          {"guard_ms", dataset.guard_ms}};
}

void from_json(const JsonView& json, StudyDataset& dataset) {
  dataset = {.file = json["file"].text(),
             .manifest_hash = json["manifest_hash"].text(),
             .samples = json["samples"].count(),
             .tick_ms = json["tick_ms"].number(),
             .guard_ms = json["guard_ms"].number()};
}

void to_json(nlohmann::json& json, const StudyTraining& training) {
  json = {{"seed", training.seed},
          {"train_run", training.train_run},
          {"th_ms", training.history_ms},
          {"runs",
           {{"train", training.train},
            {"choice", training.choice},
            {"reported", training.reported},
            {"all_test", training.all_test}}}};
}

void from_json(const JsonView& json, StudyTraining& training) {
  const JsonView runs = json["runs"];
  training = {.seed = json["seed"].count(),
              .train_run = json["train_run"].text(),
              .history_ms = json["th_ms"].number(),
              .train = runs["train"].texts(),
              .choice = runs["choice"].texts(),
              .reported = runs["reported"].texts(),
              .all_test = runs["all_test"].texts()};
}

void to_json(nlohmann::json& json, const TrainedModel& model) {
  json = {{"training", model.training}, {"seed", model.seed},
          {"th_ms", model.history_ms},  {"name", model.name},
          {"folder", model.folder},     {"history", model.history},
          {"samples", model.samples},   {"weights_sha256", model.weights_sha256}};
  if (model.accuracy) json["accuracy"] = *model.accuracy;
}

void from_json(const JsonView& json, TrainedModel& model) {
  model = {.training = json["training"].count(),
           .seed = json["seed"].count(),
           .history_ms = json["th_ms"].number(),
           .name = json["name"].text(),
           .folder = json["folder"].text(),
           .history = json["history"].text(),
           .samples = json["samples"].text(),
           .weights_sha256 = json["weights_sha256"].text(),
           .accuracy = json["accuracy"].if_there<Figure>()};
}

void to_json(nlohmann::json& json, const StudyHistory& history) {
  json = {{"th_ms", history.history_ms}, {"models", history.models}, {"accuracy", run_sets_json(history.accuracy)}};
}

void from_json(const JsonView& json, StudyHistory& history) {
  history = {json["th_ms"].number(), json["models"].list_of<TrainedModel>(), run_sets_in<Accuracy>(json["accuracy"])};
}

void to_json(nlohmann::json& json, const HistoryChoice& choice) {
  json = {{"th_ms", in_ms(choice.history)}, {"objects", nlohmann::json::object()}, {"counts", nlohmann::json::object()}};
  for (const auto& [object, history] : choice.of_objects) json["objects"][object] = in_ms(history);
  for (const auto& [history, count] : choice.counts) json["counts"][fmt::format("{}", in_ms(history))] = count;
}

void from_json(const JsonView& json, HistoryChoice& choice) {
  choice = {.history = json["th_ms"].milliseconds()};
  for (const auto& [object, history] : json["objects"].members()) choice.of_objects[object] = history.milliseconds();
  for (const auto& [history, count] : json["counts"].members())
    choice.counts[history_named(history, json["counts"])] = count.count();
}

void to_json(nlohmann::json& json, const ChosenHistory& chosen) {
  json = {{"th_ms", chosen.history_ms}, {"model", chosen.model}, {"why", chosen.why}};
}

void from_json(const JsonView& json, ChosenHistory& chosen) {
  chosen = {json["th_ms"].number(), json["model"].text(), json["why"].text()};
}

void to_json(nlohmann::json& json, const StudyChoice& choice) {
  json = static_cast<const ChosenHistory&>(choice);
  json["chosen_on"] = choice.chosen_on;
  json["trainings"] = choice.trainings;
  json["best"] = run_sets_json(choice.best);
}

void from_json(const JsonView& json, StudyChoice& choice) {
  choice = {json.get<ChosenHistory>(), json["chosen_on"].text(), json["trainings"].numbers(),
            run_sets_in<HistoryChoice>(json["best"])};
}

void to_json(nlohmann::json& json, const StudyEvaluation& evaluation) {
  json = evaluation.figures;
  json.update({{"id", evaluation.id},
               {"models", evaluation.models},
               {"runs", evaluation.runs},
               {"json", evaluation.json_file},
               {"csv", evaluation.csv_file},
               {"slip_at_once", {{"objects", evaluation.slip_at_once}}}});
}

void from_json(const JsonView& json, StudyEvaluation& evaluation) {
  evaluation = {.id = json["id"].text(),
                .models = json["models"].list_of<TrainedModel>(),
                .runs = json["runs"].text(),
                .json_file = json["json"].text(),
                .csv_file = json["csv"].text()};
  if (evaluation.models.empty() && json["model"])
    evaluation.models = {{.history_ms = json["th_ms"].number(), .name = json["model"].text()}};
  for (const char* key : evaluation_figures) {
    if (const JsonView figure = json[key]) evaluation.figures[key] = figure.copy();
  }
  for (const auto& [object, at_once] : json["slip_at_once"]["objects"].members())
    evaluation.slip_at_once[object] = at_once.truth();
}

void to_json(nlohmann::json& json, const ReportedRun& run) {
  json = {{"run", run.run}, {"model", run.model}, {"th_ms", run.history_ms}, {"csv", run.csv.string()}};
}

void from_json(const JsonView& json, ReportedRun& run) {
  run = {json["run"].text(), json["model"].text(), json["th_ms"].number(), json["csv"].text()};
}

void to_json(nlohmann::json& json, const StudyUnseen& unseen) {
  json = judged_json(unseen.on);
  json.update({{"held_out", unseen.held_out}, {"models", unseen.models}, {"trainings", unseen.trainings}});
}

void from_json(const JsonView& json, StudyUnseen& unseen) {
  unseen = {.held_out = held_out_in(json["held_out"]),
            .models = json["models"].get<UnseenComparison::Models>(),
            .trainings = json["trainings"].list_of<TrainedModel>(),
            .on = run_sets_in<UnseenComparison>(json)};
}

void to_json(nlohmann::json& json, const StudySplit& split) {
  json = judged_json(split.on);
  json.update(
      {{"name", split.name}, {"held_out", split.held_out}, {"model", split.model}, {"training", json_or_null(split.training)}});
}

void from_json(const JsonView& json, StudySplit& split) {
  split = {.name = json["name"].text(),
           .held_out = json["held_out"].texts(),
           .model = json["model"].text(),
           .training = json["training"].if_there<TrainedModel>(),
           .on = run_sets_in<UnseenComparison>(json)};
}

void to_json(nlohmann::json& json, const LeftOut& left_out) {
  json = {{"run", left_out.run}, {"what", left_out.what}, {"reason", left_out.reason}};
}

void from_json(const JsonView& json, LeftOut& left_out) {
  left_out = {json["run"].text(), json["what"].text(), json["reason"].text()};
}

void to_json(nlohmann::json& json, const Study& study) {
  json = {{"format", study_format},
          {"title", study.title},
          {"simulated", study.simulated},
          {"settings", study.settings},
          {"software", study.software},
          {"machine", study.machine},
          {"bootstrap", study.bootstrap},
          {"steps", study.steps},
          {"dataset", study.dataset},
          {"trainings", study.trainings},
          {"histories", study.histories},
          {"choice", study.choice},
          {"paper_way", study.paper_way},
          {"variance", json_or_null(study.variance)},
          {"training_spread", study.training_spread},
          {"evaluations", study.evaluations},
          {"full_runs", study.full_runs},
          {"unseen", json_or_null(study.unseen)},
          {"splits", study.splits},
          {"splits_mean", study.splits.empty() ? nlohmann::json() : judged_json(study.splits_mean)},
          {"remarks", study.remarks},
          {"left_out", study.left_out},
          {"claims", study.claims},
          {"found", study.found},
          {"summary", study.summary}};
}

void from_json(const JsonView& json, Study& study) {
  if (const std::string format = json["format"].text(); format != study_format)
    throw Error(fmt::format("{}: is of format '{}'; expected '{}'", json.where(), format, study_format));
  study = {.title = json["title"].text(),
           .simulated = json["simulated"].truth(),
           .settings = json["settings"].copy(),
           .software = json["software"].copy(),
           .machine = json["machine"].copy(),
           .bootstrap = json["bootstrap"].get<StudyBootstrap>(),
           .steps = json["steps"].list_of<StepRecord>(),
           .dataset = json["dataset"].get<StudyDataset>(),
           .trainings = json["trainings"].list_of<StudyTraining>(),
           .histories = json["histories"].list_of<StudyHistory>(),
           .choice = json["choice"].get<StudyChoice>(),
           .paper_way = json["paper_way"].get<ChosenHistory>(),
           // Older studies have three parts: trainings on single objects are in that of objects.
           .variance = json["variance"]["training_on_object"] ? json["variance"].if_there<VarianceShares>() : std::nullopt,
           .training_spread = json["training_spread"].get<TrainingSpread>(),
           .evaluations = json["evaluations"].list_of<StudyEvaluation>(),
           .full_runs = json["full_runs"].list_of<ReportedRun>(),
           .unseen = json["unseen"].if_there<StudyUnseen>(),
           .splits = json["splits"].list_of<StudySplit>(),
           .splits_mean = run_sets_in<Figure>(json["splits_mean"]),
           .remarks = json["remarks"].texts(),
           .left_out = json["left_out"].list_of<LeftOut>(),
           .claims = json["claims"].list_of<Claim>(),
           .found = json["found"].texts(),
           .summary = json["summary"].text()};
}

}  // namespace tactile::results
