#pragma once

#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::results {

/// What a study or an evaluation found, in five sentences: accuracy and the best baseline; delays and misses; false alarms;
/// objects never seen; and the claims. A sixth explains values without an interval, if there are any.
/// @param reported  of the reported runs
/// @param histories  of each training
/// @param unseen    of the reported runs; without objects if none was held out
/// @param claims    the last sentence: of a study as `summary_of` puts them
std::vector<std::string> found_in(const Evaluation& reported, const std::vector<microseconds>& histories,
                                  const UnseenComparison& unseen, const std::string& claims);

}  // namespace tactile::results
