#pragma once

#include <string>
#include <vector>

#include "tactile/results/evaluation.hpp"
#include "tactile/results/study.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::results {

// What was found, in a few sentences. The last one explains values without an interval, if there are any.

/// @param unseen  without objects if none was held out
std::vector<std::string> found_in(const Evaluation& evaluation, const UnseenComparison& unseen);

/// Of each setting that was judged on whole runs, then accuracies; without the claims.
std::vector<std::string> found_in(const Study& study);

}  // namespace tactile::results
