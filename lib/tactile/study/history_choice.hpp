#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/evaluation/accuracy.hpp"

namespace tactile {

/// Accuracies by the history t_h they were reached with.
using AccuracyByHistory = std::map<microseconds, Accuracy>;

/// Which history is best for each object, and which one follows from it.
struct HistoryChoice {
  microseconds history{0};                         ///< that is best for most objects
  std::map<std::string, microseconds> of_objects;  ///< the best one of each object, the shorter of equals
  std::map<microseconds, std::size_t> counts;      ///< of how many objects each is the best; 0 is there too
};

/// {"th_ms", "objects": {"fan": 40}, "counts": {"2": 0, "40": 6}}
void to_json(nlohmann::json& json, const HistoryChoice& choice);

/// The history that is best for the most objects; of several the one with the highest mean accuracy, and the shorter of equals.
/// @throws Error  if there is no history
/// Source: Faris et al., arXiv:2403.10120, section V.A, which takes 40 ms as the best for five objects of ten.
HistoryChoice choose_history(const AccuracyByHistory& accuracies);

/// "2", "2.5": a history in milliseconds.
std::string ms_text(microseconds us);

}  // namespace tactile
