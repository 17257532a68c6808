#pragma once

#include <map>

#include "tactile/results/study.hpp"

namespace tactile::study {

/// Accuracy for each history t_h.
using AccuracyByHistory = std::map<microseconds, results::Accuracy>;

/// The history that is best for the most objects; of several, the one with the highest mean accuracy; of equals, the shortest.
/// @throws Error  if there is no history
/// Source: Faris et al., arXiv:2403.10120, section V.A, which takes 40 ms as the best for five objects of ten.
results::HistoryChoice choose_history(const AccuracyByHistory& accuracies);

}  // namespace tactile::study
