#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// How trees are fitted. The defaults were chosen on simulated runs that no figure is reported of.
struct TreesOptions {
  unsigned rounds = 150;       ///< of one tree for each class, 1 to 10 000
  unsigned depth = 5;          ///< 1 to 8
  double learning_rate = 0.1;  ///< share of each tree that counts, in (0, 1]

  friend bool operator==(const TreesOptions&, const TreesOptions&) = default;
};

/// {"rounds", "depth", "learning_rate"}
void to_json(nlohmann::json& json, const TreesOptions& options);
void from_json(const nlohmann::json& json, TreesOptions& options);  ///< @throws Error

void check(const TreesOptions& options);  ///< @throws Error  if an option is out of its range

/// The parameters of such trees in a weights file: "trees.feature" and "trees.threshold" [rounds, 3, 2^depth - 1],
/// "trees.answer" [rounds, 3, 2^depth], as `BoostedTrees` has them. A feature's index is a whole number.
std::vector<ParameterShape> tree_parameters(const TreesOptions& options);

}  // namespace tactile::model
