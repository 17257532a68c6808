#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/evaluation/accuracy.hpp"

namespace tactile::study {

/// Accuracy for each history t_h.
using AccuracyByHistory = std::map<microseconds, results::Accuracy>;

/// The best history for each object, and the one chosen by them.
struct HistoryChoice {
  microseconds history{0};                         ///< the best one for the most objects
  std::map<std::string, microseconds> of_objects;  ///< the best one for each object, the shortest of equals
  std::map<microseconds, std::size_t> counts;      ///< the number of objects that each history is best for, 0 included
};

/// {"th_ms", "objects": {"fan": 40}, "counts": {"2": 0, "40": 6}}
void to_json(nlohmann::json& json, const HistoryChoice& choice);

/// The history that is best for the most objects; of several, the one with the highest mean accuracy; of equals, the shortest.
/// @throws Error  if there is no history
/// Source: Faris et al., arXiv:2403.10120, section V.A, which takes 40 ms as the best for five objects of ten.
HistoryChoice choose_history(const AccuracyByHistory& accuracies);

}  // namespace tactile::study
