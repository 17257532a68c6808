#include "tactile/results/evaluation.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/version.hpp"

namespace tactile::results {
namespace {

nlohmann::json detector_json(const DetectorScore& score) {
  return {{"delay_ms", {{"press", score.press}, {"slip", score.slip}}}};
}

nlohmann::json guard_json(const GuardScore& score) {
  nlohmann::json json = score.accuracy;
  json["guard_ms"] = in_ms(score.guard);
  json["difference"] = score.difference;
  json["confusion"] = score.confusion;
  return json;
}

DetectorScore detector_in(const JsonView& json) {
  const JsonView delays = json["delay_ms"];
  return {delays["press"].get<DelayTable>(), delays["slip"].get<DelayTable>()};
}

nlohmann::json model_json(const EvaluatedModel& model) {
  return {{"name", model.name}, {"settings", model.settings}, {"weights_sha256", model.weights_sha256}};
}

EvaluatedModel model_in(const JsonView& json, std::vector<std::string> test_runs) {
  return {json["name"].text(), json["settings"].copy(), json["weights_sha256"].text(), std::move(test_runs)};
}

/// Older files have one model only.
std::vector<EvaluatedModel> models_in(const JsonView& json) {
  std::vector<EvaluatedModel> models;
  for (const JsonView& training : json["trainings"].items()) models.push_back(model_in(training, training["test_runs"].texts()));
  if (models.empty()) models.push_back(model_in(json["model"], json["test_runs"].texts()));
  return models;
}

Confusion confusion_in(const JsonView& json) { return json ? json.get<Confusion>() : Confusion{}; }

GuardScore guard_in(const JsonView& json) {
  return {json["guard_ms"].milliseconds(), json.get<Accuracy>(), json["difference"].get<Accuracy>(),
          confusion_in(json["confusion"])};
}

void add_truth(nlohmann::json& json, const TruthScore& truth) {
  json["accuracy_true"] = truth.accuracy;
  json["confusion_true"] = truth.confusion;
  json["delay_true_ms"] = {{"press", truth.press}, {"slip", truth.slip}};
  json["delay_gross_ms"] = {{"slip", truth.gross_slip}};
  json["over_time_true"] = truth.over_time;
}

/// Of a simulated run.
TruthScore truth_in(const JsonView& json) {
  const JsonView delays = json["delay_true_ms"];
  return {json["accuracy_true"].get<Accuracy>(),
          confusion_in(json["confusion_true"]),
          delays["press"].get<DelayTable>(),
          delays["slip"].get<DelayTable>(),
          json["delay_gross_ms"]["slip"].get<DelayTable>(),
          json["over_time_true"].get<OverTime>()};
}

}  // namespace

void to_json(nlohmann::json& json, const Evaluation& evaluation) {
  json = {{"title", title_of(evaluation)},
          {"simulated", evaluation.simulated},
          {"model", model_json(evaluation.models.front())},
          {"trainings", nlohmann::json::array()},
          {"dataset", {{"file", evaluation.dataset}, {"manifest_hash", evaluation.manifest_hash}}},
          {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
          {"bootstrap", evaluation.bootstrap},
          {"sampling_guard_ms", in_ms(evaluation.sampling_guard)},
          {"tick_ms", in_ms(evaluation.tick)},
          {"confirm", evaluation.confirm},
          {"thresholds", evaluation.thresholds.empty() ? nlohmann::json() : nlohmann::json(evaluation.thresholds)},
          {"classes", nlohmann::json::array()},
          {"test_runs", evaluation.test_runs()},
          {"engine", {{"name", evaluation.engine}, {"ticks", evaluation.ticks}, {"close_ticks", evaluation.close_ticks}}},
          {"accuracy", evaluation.accuracy},
          {"confusion", evaluation.confusion},
          {"per_class", evaluation.classes},
          {"calibration", evaluation.calibration},
          {"calibration_whole_runs", evaluation.whole_run_calibration},
          {"label_uncertainty", evaluation.label_uncertainty},
          {"accuracy_by_guard", nlohmann::json::array()},
          {"over_time", evaluation.over_time},
          {"false_alarms_per_min", evaluation.whole_runs.decided.alarms_per_min},
          {"whole_runs", evaluation.whole_runs}};
  for (const Touch touch : all_touches) json["classes"].push_back(name_of(touch));
  for (const GuardScore& guard : evaluation.guards) json["accuracy_by_guard"].push_back(guard_json(guard));
  json.update(detector_json(evaluation.network));
  for (const auto& [name, score] : evaluation.trivial) json["trivial"][name] = detector_json(score);
  json["baselines"] = nlohmann::json::object();
  for (const BaselineScore& baseline : evaluation.baselines) {
    json["baselines"][baseline.name] = {{"accuracy", baseline.accuracy.mean}, {"objects", baseline.accuracy.objects}};
  }
  if (evaluation.truth) add_truth(json, *evaluation.truth);
  json["runs"] = nlohmann::json::array();
  for (const EvaluatedModel& model : evaluation.models) {
    nlohmann::json one = model_json(model);
    one["test_runs"] = model.test_runs;
    json["trainings"].push_back(one);
  }
  for (const RunDetections& run : evaluation.detections) {
    json["runs"].push_back(
        {{"run", run.object + "/" + run.run}, {"object", run.object}, {"training", run.training}, {"intervals", run.detections}});
  }
  json["above_baselines"] = json_or_null(evaluation.above_baselines());
}

void from_json(const JsonView& json, Evaluation& evaluation) {
  const JsonView dataset = json["dataset"], engine = json["engine"];
  evaluation = {.models = models_in(json),
                .dataset = dataset["file"].text(),
                .manifest_hash = dataset["manifest_hash"].text(),
                .simulated = json["simulated"].truth(),
                .sampling_guard = json["sampling_guard_ms"].milliseconds(),
                .tick = json["tick_ms"].milliseconds(),
                .thresholds = json["thresholds"].text(),
                .confirm = json["confirm"] ? json["confirm"].text() : "1/1",
                .bootstrap = json["bootstrap"].get<BootstrapOptions>(),
                .engine = engine["name"].text(),
                .ticks = engine["ticks"].count(),
                .close_ticks = engine["close_ticks"].count(),
                .runs = {},
                .detections = {},
                .accuracy = json["accuracy"].get<Accuracy>(),
                .confusion = confusion_in(json["confusion"]),
                .classes = json["per_class"].get<ClassScores>(),
                .calibration = json["calibration"].get<Calibration>(),
                .whole_run_calibration = json["calibration_whole_runs"].get<Calibration>(),
                .guards = {},
                .baselines = {},
                .network = detector_in(json),
                .label_uncertainty = json["label_uncertainty"].get<LabelUncertainty>(),
                .trivial = {},
                .over_time = json["over_time"].get<OverTime>(),
                .whole_runs = json["whole_runs"].get<WholeRuns>(),
                .truth = std::nullopt};
  for (const JsonView& run : json["runs"].items()) evaluation.detections.push_back(detections_in(run));
  for (const JsonView& guard : json["accuracy_by_guard"].items()) evaluation.guards.push_back(guard_in(guard));
  for (const auto& [name, baseline] : json["baselines"].members())
    evaluation.baselines.push_back({name, {baseline["accuracy"].get<Figure>(), baseline["objects"].map_of<Figure>()}});
  for (const auto& [name, detector] : json["trivial"].members()) evaluation.trivial.emplace(name, detector_in(detector));
  if (json["accuracy_true"] || json["delay_true_ms"]) evaluation.truth = truth_in(json);
}

std::vector<std::string> Evaluation::test_runs() const {
  std::vector<std::string> names;
  for (const EvaluatedModel& model : models) names.insert(names.end(), model.test_runs.begin(), model.test_runs.end());
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::optional<bool> Evaluation::above_baselines() const {
  if (!accuracy.mean.low || baselines.empty()) return std::nullopt;
  bool above = true;
  for (const BaselineScore& baseline : baselines) {
    if (!baseline.accuracy.mean.high) return std::nullopt;
    above = above && *accuracy.mean.low > *baseline.accuracy.mean.high;
  }
  return above;
}

std::string title_of(const Evaluation& evaluation) {
  const char* const kind = evaluation.simulated ? "simulated" : "real";
  std::set<double> histories_ms;
  for (const EvaluatedModel& model : evaluation.models)
    histories_ms.insert(1e-3 * model.settings.value(nlohmann::json::json_pointer("/rendering/history_us"), 0.0));
  if (histories_ms.size() > 1) {
    return fmt::format("Evaluation of {} trainings, each with the t_h that it chose ({} ms), on {} runs",
                       evaluation.models.size(), fmt::join(histories_ms, ", "), kind);
  }
  const std::size_t more = evaluation.models.size() - 1;
  return fmt::format("Evaluation of {}{} on {} runs", evaluation.models.front().name,
                     more == 0   ? std::string()
                     : more == 1 ? std::string(" and another training")
                                 : fmt::format(" and {} more trainings", more),
                     kind);
}

}  // namespace tactile::results
