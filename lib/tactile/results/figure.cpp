#include "tactile/results/figure.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactile::results {

Figure scaled(Figure figure, double factor) {
  const auto times_factor = [factor](double value) { return value * factor + 0.0; };  // never -0
  figure.value = times_factor(figure.value);
  if (figure.low) figure.low = times_factor(*figure.low);
  if (figure.high) figure.high = times_factor(*figure.high);
  if (factor < 0) std::swap(figure.low, figure.high);
  return figure;
}

std::string text_of(const Figure& figure, std::string_view unit, std::string_view format) {
  if (!std::isfinite(figure.value)) return "unknown";
  const std::string of_number = fmt::format("{{:{}}}", format);
  const auto number = [&](double value) { return fmt::format(fmt::runtime(of_number), value); };
  std::string value = fmt::format("{}{}", number(figure.value), unit);
  if (!figure.has_interval()) return value;
  return fmt::format("{} [{}, {}]", value, number(*figure.low), number(*figure.high));
}

std::string note_on_intervals(std::initializer_list<Figure> figures) {
  const bool lacks_one = std::any_of(figures.begin(), figures.end(),
                                     [](const Figure& figure) { return std::isfinite(figure.value) && !figure.has_interval(); });
  if (!lacks_one) return "";
  return "A value without brackets has no 95 % interval: that needs three objects, or three runs of one object, and not two "
         "trainings.";
}

nlohmann::json number_or_null(double number) { return std::isfinite(number) ? nlohmann::json(number) : nlohmann::json(); }

void to_json(nlohmann::json& json, const Figure& figure) {
  json = {{"value", number_or_null(figure.value)},
          {"low", number_or_null(figure.low.value_or(NAN))},
          {"high", number_or_null(figure.high.value_or(NAN))},
          {"n", figure.n},
          {"trainings", figure.trainings}};
}

void from_json(const JsonView& json, Figure& figure) {
  if (json.is_number()) {
    figure = {.value = json.number(), .low = {}, .high = {}, .n = 0, .trainings = 1};
  } else if (json) {
    figure = {json["value"].number(), json["low"].number_if_there(), json["high"].number_if_there(), json["n"].count(),
              json["trainings"] ? json["trainings"].count() : 1};
  }
}

void to_json(nlohmann::json& json, const BootstrapOptions& options) {
  json = {{"draws", options.draws}, {"confidence", options.confidence}, {"seed", options.seed}};
}

void from_json(const JsonView& json, BootstrapOptions& options) {
  options = {json["draws"].count(), json["confidence"].number(), json["seed"].count()};
}

}  // namespace tactile::results
