#include "tactile/results/detection.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"

namespace tactile::results {

std::string words_of(const Detection& detection) {
  switch (detection.outcome) {
    case DetectionOutcome::detected:
      return fmt::format("{} ms", in_ms(detection.delay));
    case DetectionOutcome::missed:
      return "missed";
    case DetectionOutcome::early:
      return "early";
  }
  return "";
}

std::string_view name_of(DetectionOutcome outcome) {
  switch (outcome) {
    case DetectionOutcome::detected:
      return "detected";
    case DetectionOutcome::missed:
      return "missed";
    case DetectionOutcome::early:
      return "early";
  }
  return "missed";
}

void to_json(nlohmann::json& json, const Detection& detection) {
  json = {
      {"class", name_of(detection.interval.touch)},
      {"start_us", us_of(detection.interval.start)},
      {"end_us", us_of(detection.interval.end)},
      {"outcome", name_of(detection.outcome)},
      {"delay_ms", detection.outcome == DetectionOutcome::detected ? nlohmann::json(in_ms(detection.delay)) : nlohmann::json()},
      {"ahead", detection.ahead},
      {"limit_ms", in_ms(detection.limit)}};
}

void from_json(const JsonView& json, Detection& detection) {
  detection.interval = {touch_named(json["class"].text()), camera_time(json["start_us"].whole_number()),
                        camera_time(json["end_us"].whole_number())};
  const JsonView outcome = json["outcome"];
  const auto all = {DetectionOutcome::detected, DetectionOutcome::missed, DetectionOutcome::early};
  const auto found = std::find_if(all.begin(), all.end(), [&](DetectionOutcome one) { return name_of(one) == outcome.text(); });
  if (found == all.end()) throw Error(outcome.where() + " is '" + outcome.text() + "'; expected detected, missed or early");
  detection.outcome = *found;
  if (detection.outcome == DetectionOutcome::detected) detection.delay = json["delay_ms"].milliseconds();
  detection.ahead = json["ahead"].truth();
  detection.limit = json["limit_ms"].milliseconds();
}

}  // namespace tactile::results
