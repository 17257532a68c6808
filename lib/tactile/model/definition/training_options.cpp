#include "tactile/model/definition/training_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::model {
namespace {

constexpr std::string_view stress_prefix = "stress:";

std::vector<std::string> parts_of(std::string_view text) {
  std::vector<std::string> parts;
  std::istringstream stream{std::string(text)};
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

Augmentation augmentation_named(std::string_view names) {
  Augmentation augmentation;
  if (names == "none") return augmentation;
  const auto parts = parts_of(names);
  for (const std::string& part : parts) {
    if (part == "flip")
      augmentation.flip = true;
    else if (part == "shift")
      augmentation.shift = true;
    else if (part.starts_with(stress_prefix))
      augmentation.stress.push_back(recipes::parse_recipe(std::string_view(part).substr(stress_prefix.size())));
    else
      throw Error(fmt::format("augmentation '{}' is unknown; expected none, or flip, shift and stress:RECIPE", names));
  }
  if (parts.empty()) throw Error("augmentation: none is named; expected none, or flip, shift and stress:RECIPE");
  return augmentation;
}

ClassWeights class_weights_named(std::string_view text) {
  ClassWeights weights;
  if (text == "none") return weights;
  weights.balanced = text == "balanced";
  if (weights.balanced) return weights;
  const auto parts = parts_of(text);
  for (std::size_t i = 0; i < touch_count; ++i) {
    const auto weight = parts.size() == touch_count ? number_in(parts[i]) : std::nullopt;
    if (!weight || !(*weight > 0) || !std::isfinite(*weight))
      throw Error(
          fmt::format("class weights '{}'; expected none, balanced, or a number above 0 for each of none, press and slip: "
                      "1,2,1",
                      text));
    weights.given[i] = *weight;
  }
  return weights;
}

std::string text_of(const Augmentation& augmentation) {
  std::vector<std::string> parts;
  if (augmentation.flip) parts.emplace_back("flip");
  if (augmentation.shift) parts.emplace_back("shift");
  for (const recipes::Recipe& recipe : augmentation.stress)
    parts.push_back(std::string(stress_prefix) + recipes::text_of(recipe));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ","));
}

std::string text_of(const ClassWeights& weights) {
  if (weights.balanced) return "balanced";
  if (weights == ClassWeights{}) return "none";
  return fmt::format("{},{},{}", weights.given[0], weights.given[1], weights.given[2]);
}

void check(const TrainingOptions& options) {
  if (options.epochs == 0 || options.batch == 0) {
    throw Error(fmt::format("training: {} epochs in batches of {}; expected at least 1 of each", options.epochs, options.batch));
  }
  if (!(options.learning_rate > 0) || !std::isfinite(options.learning_rate)) {
    throw Error(fmt::format("training: a learning rate of {}; expected more than 0", options.learning_rate));
  }
  if (!(options.validation_share >= 0 && options.validation_share <= 0.5)) {
    throw Error(fmt::format("training: a validation part of {}; expected 0 to 0.5", options.validation_share));
  }
  if (options.early_stop > 0 && options.validation_share == 0)
    throw Error("training: early stop needs a validation part; expected a share above 0");
}

double learning_rate_at(const TrainingOptions& options, std::uint64_t step, std::uint64_t steps) {
  const double share = static_cast<double>(step) / static_cast<double>(steps);
  if (options.schedule == Schedule::cosine) return options.learning_rate * 0.5 * (1 + std::cos(std::numbers::pi * share));
  if (options.schedule == Schedule::step) return options.learning_rate * (share < 0.5 ? 1.0 : share < 0.75 ? 0.1 : 0.01);
  return options.learning_rate;
}

}  // namespace tactile::model
