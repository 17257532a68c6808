#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "tactile/core/touch.hpp"
#include "tactile/model/inference/boosted_trees.hpp"

namespace tactile::model {

/// How trees are fitted. The defaults were chosen on simulated runs that no figure is reported of.
struct TreesOptions {
  unsigned rounds = 150;       ///< 1 to 10 000
  unsigned depth = 5;          ///< 1 to 8
  double learning_rate = 0.1;  ///< share of each tree that counts, in (0, 1]
  std::uint64_t seed = 1;      ///< of the random samples and features that each tree is fitted on: 70 % and 50 %
};

/// What libxgboost gets of these options.
std::map<std::string, std::string> xgboost_parameters(const TreesOptions& options);

/// Fits trees to the cross-entropy, by libxgboost on one thread. The same input and library give the same trees.
/// @param features  [truth.size(), feature count], finite
/// @throws Error    if there is no sample or not as many features for each, or an option is out of its range
BoostedTrees fit_trees(std::span<const float> features, std::span<const Touch> truth, const TreesOptions& options = {});

}  // namespace tactile::model
