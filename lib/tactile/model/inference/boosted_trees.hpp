#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/trees_options.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

/// Gradient-boosted decision trees: in each round one tree of each class. A logit is the sum of what the trees of its class
/// answer. At a node a tree goes left if feature < threshold, else right; so a NaN would go right, but features have none.
///
/// All trees have the same depth d. One that ends earlier repeats its answer: so a tree is 2^d - 1 nodes and 2^d answers, and a
/// prediction takes the same time for every input. Immutable and thread-safe; `logits` allocates no memory.
///
/// Source of the method: Friedman, Greedy function approximation, Annals of Statistics 29, 2001; Chen and Guestrin, KDD 2016.
class BoostedTrees {
 public:
  struct Node {
    std::uint32_t feature = 0;
    float threshold = 0;
  };

  /// @param nodes    [rounds, touch_count, 2^depth - 1], each tree level by level
  /// @param answers  [rounds, touch_count, 2^depth], from left to right
  /// @throws Error   if the sizes do not fit, the depth is not 1 to 8, a node names no feature, or a number is not finite
  BoostedTrees(std::size_t features, unsigned depth, std::vector<Node> nodes, std::vector<float> answers);

  /// The trees of a weights file, with the parameters of `tree_parameters`.
  /// @throws Error   also if the shapes differ, or the index of a feature is no whole number
  BoostedTrees(std::size_t features, const TreesOptions& options, const Weights& weights);

  std::size_t features() const { return features_; }
  std::size_t rounds() const { return answers_.size() / touch_count >> depth_; }

  /// As a weights file has them.
  Weights weights() const;

  /// The sums are float32, in the order of the rounds. @throws Error  if there are not `features()` of them
  Logits logits(std::span<const float> features) const;

 private:
  std::size_t features_;
  unsigned depth_;
  std::vector<Node> nodes_;
  std::vector<float> answers_;
};

}  // namespace tactile::model
