#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// Accuracies of single trainings with one history, each on the runs that it reports on.
struct TrainingSpread {
  double history_ms = 40;
  std::vector<double> mean{};                            ///< over objects; one for each training, in [0, 1]
  std::map<std::string, std::vector<double>> objects{};  ///< one for each training that has runs of the object
};

/// How far trainings of one setting are apart on single objects: the largest range, with its object, the median range over
/// objects, and the range of the mean. Empty where no object has two trainings.
std::string words_of(const TrainingSpread& spread);

/// {"th_ms", "mean", "objects", "in_words"}; null where there are no words.
void to_json(nlohmann::json& json, const TrainingSpread& spread);
void from_json(const JsonView& json, TrainingSpread& spread);

}  // namespace tactile::results
