#include "tactile/results/training_spread.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::results {
namespace {

double range_of(const std::vector<double>& accuracies) {
  if (accuracies.empty()) return 0;
  const auto [least, most] = std::minmax_element(accuracies.begin(), accuracies.end());
  return *most - *least;
}

}  // namespace

std::string words_of(const TrainingSpread& spread) {
  std::vector<double> ranges;
  auto widest = spread.objects.end();
  for (auto object = spread.objects.begin(); object != spread.objects.end(); ++object) {
    if (object->second.size() < 2) continue;
    ranges.push_back(range_of(object->second));
    if (widest == spread.objects.end() || ranges.back() > range_of(widest->second)) widest = object;
  }
  if (widest == spread.objects.end()) return {};
  const auto [least, most] = std::minmax_element(widest->second.begin(), widest->second.end());
  return fmt::format(
      "{} trainings with a t_h of {:g} ms, each on its own reported runs: on one object their accuracies are up to {:.1f} points "
      "apart ({}: {:.1f} to {:.1f} %), on the median object {:.1f} points, in the mean over objects {:.1f} points.",
      spread.mean.size(), spread.history_ms, 100 * (*most - *least), widest->first, 100 * *least, 100 * *most,
      100 * median<double>(ranges), 100 * range_of(spread.mean));
}

void to_json(nlohmann::json& json, const TrainingSpread& spread) {
  const std::string words = words_of(spread);
  json = nullptr;
  if (!words.empty())
    json = {{"th_ms", spread.history_ms}, {"mean", spread.mean}, {"objects", spread.objects}, {"in_words", words}};
}

void from_json(const JsonView& json, TrainingSpread& spread) {
  spread = {.history_ms = json["th_ms"].number(), .mean = json["mean"].numbers()};
  for (const auto& [object, accuracies] : json["objects"].members()) spread.objects[object] = accuracies.numbers();
}

}  // namespace tactile::results
