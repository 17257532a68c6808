#include "tactile/model/inference/boosted_trees.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

/// The weights, once they have the shapes of these options.
const Weights& checked(const Weights& weights, const TreesOptions& options) {
  check(options);
  check_shapes(weights, tree_parameters(options), "trees with other parameters than their settings");
  return weights;
}

std::vector<BoostedTrees::Node> nodes_in(const Weights& weights) {
  const std::vector<float>&features = weights[0].values, &thresholds = weights[1].values;
  std::vector<BoostedTrees::Node> nodes(features.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    constexpr float most = 65'536;
    const float feature = features[i];
    if (!(feature >= 0 && feature < most && feature == std::floor(feature)))
      throw Error(fmt::format("a node of a tree compares feature {}; expected a whole number from 0", feature));
    nodes[i] = {static_cast<std::uint32_t>(feature), thresholds[i]};
  }
  return nodes;
}

}  // namespace

BoostedTrees::BoostedTrees(std::size_t features, const TreesOptions& options, const Weights& weights)
    : BoostedTrees(features, options.depth, nodes_in(checked(weights, options)), checked(weights, options)[2].values) {}

Weights BoostedTrees::weights() const {
  const std::vector<ParameterShape> shapes = tree_parameters({.rounds = static_cast<unsigned>(rounds()), .depth = depth_});
  Weights weights{{shapes[0], {}}, {shapes[1], {}}, {shapes[2], answers_}};
  for (const Node& node : nodes_) {
    weights[0].values.push_back(static_cast<float>(node.feature));
    weights[1].values.push_back(node.threshold);
  }
  return weights;
}

BoostedTrees::BoostedTrees(std::size_t features, unsigned depth, std::vector<Node> nodes, std::vector<float> answers)
    : features_(features), depth_(depth), nodes_(std::move(nodes)), answers_(std::move(answers)) {
  constexpr unsigned deepest = 8;
  if (depth < 1 || depth > deepest) throw Error(fmt::format("trees of depth {}; expected 1 to {}", depth, deepest));
  const std::size_t leaves = std::size_t{1} << depth, trees = answers_.size() / leaves;
  if (answers_.empty() || answers_.size() % (touch_count * leaves) != 0 || nodes_.size() != trees * (leaves - 1)) {
    throw Error(fmt::format("{} nodes and {} answers of trees; expected {} and {} for each round of {} trees", nodes_.size(),
                            answers_.size(), touch_count * (leaves - 1), touch_count * leaves, touch_count));
  }
  for (const Node& node : nodes_) {
    if (node.feature >= features || !std::isfinite(node.threshold)) {
      throw Error(fmt::format("a node of a tree compares feature {} with {}; expected one of {} and a finite number",
                              node.feature, node.threshold, features));
    }
  }
  if (!std::all_of(answers_.begin(), answers_.end(), [](float answer) { return std::isfinite(answer); }))
    throw Error("an answer of a tree is not finite; expected finite ones");
}

Logits BoostedTrees::logits(std::span<const float> features) const {
  if (features.size() != features_) throw Error(fmt::format("{} features; expected {}", features.size(), features_));
  const std::size_t leaves = std::size_t{1} << depth_, inner = leaves - 1;
  Logits logits{};
  const Node* nodes = nodes_.data();
  const float* answers = answers_.data();
  for (std::size_t round = rounds(); round > 0; --round) {
    for (float& logit : logits) {
      std::size_t place = 0;
      for (unsigned level = 0; level < depth_; ++level) {
        const Node& node = nodes[place];
        place = 2 * place + (features[node.feature] < node.threshold ? 1 : 2);
      }
      logit += answers[place - inner];
      nodes += inner, answers += leaves;
    }
  }
  return logits;
}

}  // namespace tactile::model
