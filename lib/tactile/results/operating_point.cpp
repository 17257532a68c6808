#include "tactile/results/operating_point.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const OperatingPoint& point) {
  json = {{"threshold", point.threshold},
          {"delay_ms", {{"press", point.press}, {"slip", point.slip}}},
          {"false_alarms_per_min", point.false_alarms_per_min},
          {"false_alarms", point.false_alarms},
          {"outside_labels_per_min", point.outside_labels_per_min},
          {"wrong_class_per_min", point.wrong_class_per_min}};
}

void from_json(const JsonView& json, OperatingPoint& point) {
  const JsonView delays = json["delay_ms"];
  point = {json["threshold"].number(),
           delays["press"].get<DelaySummary>(),
           delays["slip"].get<DelaySummary>(),
           json["false_alarms_per_min"].get<Figure>(),
           json["false_alarms"].count(),
           json["outside_labels_per_min"].get<Figure>(),
           json["wrong_class_per_min"].get<Figure>()};
}

}  // namespace tactile::results
