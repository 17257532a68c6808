#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/definition/trees_options.hpp"
#include "tactile/model/inference/boosted_trees.hpp"

namespace tactile::model {

/// What libxgboost gets of these options.
/// @param seed  of the random samples and features that each tree is fitted on: 70 % and 50 %
std::map<std::string, std::string> xgboost_parameters(const TreesOptions& options, std::uint64_t seed);

/// Fits trees to the cross-entropy, by libxgboost on one thread. The same input and library give the same trees.
/// @param features  [truth.size(), feature count], finite
/// @param progress  called after each round; an exception from it ends the fit
/// @throws Error    if there is no sample or not as many features for each, or an option is out of its range
BoostedTrees fit_trees(std::span<const float> features, std::span<const Touch> truth, const TreesOptions& options = {},
                       std::uint64_t seed = 1, const ProgressCallback& progress = {});

}  // namespace tactile::model
