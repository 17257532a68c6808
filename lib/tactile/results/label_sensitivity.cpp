#include "tactile/results/label_sensitivity.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const SpreadByLabels& spread) {
  json = {{"mean", number_or_null(spread.mean)},
          {"low", number_or_null(spread.low)},
          {"high", number_or_null(spread.high)},
          {"with_runs", spread.with_runs}};
}

void from_json(const JsonView& json, SpreadByLabels& spread) {
  spread = {json["mean"].number(), json["low"].number(), json["high"].number(), json["with_runs"].get<Figure>()};
}

void to_json(nlohmann::json& json, const LabelUncertainty& uncertainty) {
  json = {{"draws", uncertainty.draws},
          {"accuracy", uncertainty.accuracy},
          {"delay_ms",
           {{"press", {{"mean", uncertainty.press_mean_ms}, {"median_of_all", uncertainty.press_median_ms}}},
            {"slip", {{"mean", uncertainty.slip_mean_ms}, {"median_of_all", uncertainty.slip_median_ms}}}}}};
}

void from_json(const JsonView& json, LabelUncertainty& uncertainty) {
  const JsonView press = json["delay_ms"]["press"], slip = json["delay_ms"]["slip"];
  uncertainty = {.draws = json["draws"].count(),
                 .accuracy = json["accuracy"].get<SpreadByLabels>(),
                 .press_mean_ms = press["mean"].get<SpreadByLabels>(),
                 .slip_mean_ms = slip["mean"].get<SpreadByLabels>(),
                 .press_median_ms = press["median_of_all"].get<SpreadByLabels>(),
                 .slip_median_ms = slip["median_of_all"].get<SpreadByLabels>()};
}

}  // namespace tactile::results
