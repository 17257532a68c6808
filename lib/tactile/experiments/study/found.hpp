#pragma once

#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::study {

/// What a study found, in five sentences: accuracy and the best baseline; delays and misses; false alarms; objects never seen;
/// and the claims.
/// @param reported  of the reported runs
/// @param histories  that each training chose
/// @param unseen    of the reported runs; without objects if none was held out
/// @param claims    as `summary_of` puts them
std::vector<std::string> found_in(const results::Evaluation& reported, const std::vector<microseconds>& histories,
                                  const results::UnseenComparison& unseen, const std::string& claims);

}  // namespace tactile::study
