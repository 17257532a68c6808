#include "tactile/core/version.hpp"
#include "tactile/evaluation/evaluation.hpp"

namespace tactile {
namespace {

double in_ms(microseconds us) { return static_cast<double>(us.count()) / 1000; }

nlohmann::json detector_json(const DetectorScore& score) {
  return {{"delay_ms", {{"press", score.press}, {"slip", score.slip}}},
          {"false_alarms_per_min", score.false_alarms.per_min},
          {"false_alarms", score.false_alarms}};
}

nlohmann::json guard_json(const GuardScore& score) {
  nlohmann::json json = score.accuracy;
  json["guard_ms"] = in_ms(score.guard);
  json["difference"] = score.difference;
  json["confusion"] = score.confusion;
  return json;
}

nlohmann::json gate_json(const GateOff& off) {
  nlohmann::json without = detector_json(off.network);
  without["accuracy"] = off.accuracy;
  without["confusion"] = off.confusion;
  return {{"limit_events", off.limit}, {"ticks", off.ticks}, {"gated", off.gated}, {"off", without}};
}

void add_truth(nlohmann::json& json, const TruthScore& truth) {
  json["accuracy_true"] = truth.accuracy;
  json["confusion_true"] = truth.confusion;
  json["delay_true_ms"] = {{"press", truth.press}, {"slip", truth.slip}};
  json["delay_gross_ms"] = {{"slip", truth.gross_slip}};
  json["false_alarms_true"] = truth.false_alarms;
  json["over_time_true"] = truth.over_time;
}

}  // namespace

void to_json(nlohmann::json& json, const Evaluation& evaluation) {
  json = {
      {"title", title_of(evaluation)},
      {"simulated", evaluation.simulated},
      {"model", evaluation.model},
      {"dataset", {{"file", evaluation.dataset}, {"manifest_hash", evaluation.manifest_hash}}},
      {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
      {"bootstrap",
       {{"draws", evaluation.bootstrap.draws},
        {"confidence", evaluation.bootstrap.confidence},
        {"seed", evaluation.bootstrap.seed}}},
      {"guard_ms", in_ms(evaluation.guard)},
      {"sampling_guard_ms", in_ms(evaluation.sampling_guard)},
      {"tick_ms", in_ms(evaluation.tick)},
      {"confirm", text_of(evaluation.confirmation)},
      {"classes", nlohmann::json::array()},
      {"test_runs", evaluation.test_runs},
      {"engine", {{"name", name_of(evaluation.engine)}, {"ticks", evaluation.ticks}, {"close_ticks", evaluation.close_ticks}}},
      {"accuracy", evaluation.accuracy},
      {"confusion", evaluation.confusion},
      {"per_class", evaluation.classes},
      {"calibration", evaluation.calibration},
      {"accuracy_by_guard", nlohmann::json::array()},
      {"over_time", evaluation.over_time},
      {"operating_curve", evaluation.operating_curve}};
  for (const Touch touch : all_touches) json["classes"].push_back(name_of(touch));
  for (const GuardScore& guard : evaluation.guards) json["accuracy_by_guard"].push_back(guard_json(guard));
  json.update(detector_json(evaluation.network));
  for (const auto& [name, score] : evaluation.trivial) json["trivial"][name] = detector_json(score);
  json["baselines"] = nlohmann::json::object();
  for (const BaselineScore& baseline : evaluation.baselines) {
    json["baselines"][baseline.name] = {{"accuracy", baseline.accuracy.mean}, {"objects", baseline.accuracy.objects}};
  }
  json["gate"] = evaluation.gate_off ? gate_json(*evaluation.gate_off) : nlohmann::json();
  if (evaluation.truth) add_truth(json, *evaluation.truth);
  json["runs"] = nlohmann::json::array();
  for (std::size_t i = 0; i < evaluation.detections.size(); ++i) {
    json["runs"].push_back({{"run", evaluation.test_runs[i]},
                            {"object", evaluation.detections[i].object},
                            {"intervals", evaluation.detections[i].detections}});
  }
  const auto above = evaluation.above_baselines();
  json["above_baselines"] = above ? nlohmann::json(*above) : nlohmann::json();
}

}  // namespace tactile
