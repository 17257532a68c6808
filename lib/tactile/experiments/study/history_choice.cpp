#include "tactile/experiments/study/history_choice.hpp"

#include <tuple>

#include "tactile/core/error.hpp"

namespace tactile::study {

results::HistoryChoice choose_history(const AccuracyByHistory& accuracies) {
  if (accuracies.empty()) throw Error("no history to choose from; expected one at least");
  results::HistoryChoice choice;
  std::map<std::string, double> highest;
  for (const auto& [history, accuracy] : accuracies) {
    choice.counts[history] = 0;
    for (const auto& [object, figure] : accuracy.objects) {
      const auto [best, is_new] = highest.try_emplace(object, figure.value);
      if (!is_new && !(figure.value > best->second)) continue;
      best->second = figure.value;
      choice.of_objects[object] = history;
    }
  }
  for (const auto& [object, history] : choice.of_objects) ++choice.counts[history];
  choice.history = accuracies.begin()->first;
  const auto rank = [&](microseconds history) {
    return std::tuple(choice.counts.at(history), accuracies.at(history).mean.value);
  };
  for (const auto& [history, accuracy] : accuracies) {
    if (rank(history) > rank(choice.history)) choice.history = history;
  }
  return choice;
}

}  // namespace tactile::study
