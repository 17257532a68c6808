#include "tactile/results/stress.hpp"

#include <fmt/core.h>

#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile::results {
void to_json(nlohmann::json& json, const StressCurve& curve) {
  json = {{"name", curve.name},       {"is_world", curve.is_world}, {"unit", curve.unit},
          {"meaning", curve.meaning}, {"points", curve.points},     {"holds_up_to", nullptr}};
  if (curve.holds) json["holds_up_to"] = {{"severity", curve.holds->severity}, {"is_beyond", curve.holds->is_beyond}};
}

void from_json(const JsonView& json, StressCurve& curve) {
  curve = {.name = json["name"].text(),
           .is_world = json["is_world"].truth(),
           .unit = json["unit"].text(),
           .meaning = json["meaning"].text(),
           .points = json["points"].list_of<StressPoint>()};
  if (const JsonView holds = json["holds_up_to"])
    curve.holds = HoldsUpTo{holds["severity"].get<Figure>(), holds["is_beyond"].truth()};
}

void to_json(nlohmann::json& json, const StressedModel& model) {
  json = {{"name", model.name},
          {"trainings", model.trainings},
          {"runs", model.runs},
          {"curves", model.curves},
          {"quiet", model.quiet}};
}

void from_json(const JsonView& json, StressedModel& model) {
  model = {.name = json["name"].text(),
           .trainings = json["trainings"].texts(),
           .runs = json["runs"].texts(),
           .curves = json["curves"].list_of<StressCurve>(),
           .quiet = json["quiet"].list_of<StressCurve>()};
}

void to_json(nlohmann::json& json, const Stress& stress) {
  json = {{"format", stress_format},
          {"title", stress.title},
          {"simulated", stress.simulated},
          {"judged_by", stress.judged_by},
          {"manifest_hash", text_or_null(stress.manifest_hash)},
          {"quiet_files", stress.quiet_files},
          {"seed", stress.seed},
          {"most_lost", stress.most_lost},
          {"confirm", stress.confirm},
          {"engine", stress.engine},
          {"bootstrap", stress.bootstrap},
          {"models", stress.models},
          {"settings", stress.settings},
          {"software", stress.software},
          {"machine", stress.machine},
          {"steps", stress.steps}};
}

void from_json(const JsonView& json, Stress& stress) {
  if (json["format"].text() != stress_format) {
    throw Error(
        fmt::format("{} is another one; expected {}, as 'tactile stress' writes it", json["format"].where(), stress_format));
  }
  stress = {.title = json["title"].text(),
            .simulated = json["simulated"].truth(),
            .judged_by = json["judged_by"].text(),
            .manifest_hash = json["manifest_hash"].text(),
            .quiet_files = json["quiet_files"].texts(),
            .seed = json["seed"].count(),
            .most_lost = json["most_lost"].number(),
            .confirm = json["confirm"].text(),
            .engine = json["engine"].text(),
            .bootstrap = json["bootstrap"].get<BootstrapOptions>(),
            .models = json["models"].list_of<StressedModel>(),
            .settings = json["settings"].copy(),
            .software = json["software"].copy(),
            .machine = json["machine"].copy(),
            .steps = json["steps"].list_of<StepRecord>()};
}

std::string words_of(const StressCurve& curve) {
  if (!curve.holds || curve.points.empty() || !std::isfinite(curve.holds->severity.value)) return "unknown";
  const Figure& severity = curve.holds->severity;
  const bool is_on_or_off = curve.unit.empty() && curve.points.size() == 2;
  if (is_on_or_off) return curve.holds->is_beyond ? "holds" : "does not hold";
  const std::string unit = curve.unit.empty() ? "" : " " + curve.unit;
  const auto number = [](double value) {
    return std::abs(value) >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
  };
  if (curve.holds->is_beyond) return fmt::format("beyond {}{}", number(curve.points.back().severity), unit);
  const std::string interval =
      severity.has_interval() ? fmt::format(" [{}, {}]", number(*severity.low), number(*severity.high)) : "";
  return fmt::format("up to {}{}{}", number(severity.value), unit, interval);
}

}  // namespace tactile::results
