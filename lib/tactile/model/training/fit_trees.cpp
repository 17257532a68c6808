#include "tactile/model/training/fit_trees.hpp"

#include <fmt/core.h>
#include <xgboost/c_api.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

void check_call(int failed) {
  if (failed != 0) throw Error(fmt::format("fitting trees: libxgboost reports '{}'; expected no error", XGBGetLastError()));
}

using Matrix = std::unique_ptr<std::remove_pointer_t<DMatrixHandle>, int (*)(DMatrixHandle)>;
using Booster = std::unique_ptr<std::remove_pointer_t<BoosterHandle>, int (*)(BoosterHandle)>;

Matrix matrix_of(std::span<const float> features, std::span<const Touch> truth) {
  DMatrixHandle handle = nullptr;
  check_call(XGDMatrixCreateFromMat(features.data(), truth.size(), features.size() / truth.size(),
                                    std::numeric_limits<float>::quiet_NaN(), &handle));
  Matrix matrix(handle, XGDMatrixFree);
  std::vector<float> labels;
  for (const Touch touch : truth) labels.push_back(static_cast<float>(touch));
  check_call(XGDMatrixSetFloatInfo(handle, "label", labels.data(), labels.size()));
  return matrix;
}

Booster booster_of(const Matrix& matrix, const TreesOptions& options, std::uint64_t seed) {
  const DMatrixHandle matrices[] = {matrix.get()};
  BoosterHandle handle = nullptr;
  check_call(XGBoosterCreate(matrices, 1, &handle));
  Booster booster(handle, XGBoosterFree);
  for (const auto& [name, value] : xgboost_parameters(options, seed))
    check_call(XGBoosterSetParam(handle, name.c_str(), value.c_str()));
  return booster;
}

/// Copies the part of a fitted tree below `node` to the part of ours below `place`; an answer goes to all places below its own.
void copy_tree(const nlohmann::json& tree, std::size_t node, std::size_t place, std::span<BoostedTrees::Node> nodes,
               std::span<float> answers) {
  const int left = tree.at("left_children").at(node), right = tree.at("right_children").at(node);
  const bool is_leaf = left < 0;
  const float value = tree.at("split_conditions").at(node);
  if (place >= nodes.size()) {
    if (!is_leaf) throw Error("fitting trees: libxgboost made a deeper tree than asked for; expected none");
    answers[place - nodes.size()] = value;
    return;
  }
  nodes[place] = is_leaf ? BoostedTrees::Node{} : BoostedTrees::Node{tree.at("split_indices").at(node), value};
  copy_tree(tree, is_leaf ? node : static_cast<std::size_t>(left), 2 * place + 1, nodes, answers);
  copy_tree(tree, is_leaf ? node : static_cast<std::size_t>(right), 2 * place + 2, nodes, answers);
}

BoostedTrees trees_of(const Booster& booster, std::size_t features, unsigned depth) {
  bst_ulong length = 0;
  const char* text = nullptr;
  check_call(XGBoosterSaveModelToBuffer(booster.get(), R"({"format": "json"})", &length, &text));
  const auto model = nlohmann::json::parse(text, text + length);
  const nlohmann::json& trees = model.at("learner").at("gradient_booster").at("model").at("trees");
  const std::size_t leaves = std::size_t{1} << depth;
  std::vector<BoostedTrees::Node> nodes(trees.size() * (leaves - 1));
  std::vector<float> answers(trees.size() * leaves);
  for (std::size_t i = 0; i < trees.size(); ++i)
    copy_tree(trees[i], 0, 0, std::span(nodes).subspan(i * (leaves - 1), leaves - 1),
              std::span(answers).subspan(i * leaves, leaves));
  return {features, depth, std::move(nodes), std::move(answers)};
}

}  // namespace

std::map<std::string, std::string> xgboost_parameters(const TreesOptions& options, std::uint64_t seed) {
  return {{"objective", "multi:softprob"},
          {"num_class", std::to_string(touch_count)},
          {"base_score", "0.5"},
          {"tree_method", "hist"},
          {"max_depth", std::to_string(options.depth)},
          {"eta", fmt::format("{}", options.learning_rate)},
          {"subsample", "0.7"},
          {"colsample_bytree", "0.5"},
          {"seed", std::to_string(seed % 2'147'483'647)},
          {"nthread", "1"},
          {"verbosity", "0"}};
}

BoostedTrees fit_trees(std::span<const float> features, std::span<const Touch> truth, const TreesOptions& options,
                       std::uint64_t seed, const ProgressCallback& progress) {
  if (truth.empty() || features.empty() || features.size() % truth.size() != 0)
    throw Error(fmt::format("fitting trees: {} features of {} samples; expected a sample at least, and as many features for each",
                            features.size(), truth.size()));
  if (!std::all_of(features.begin(), features.end(), [](float feature) { return std::isfinite(feature); }))
    throw Error("fitting trees: a feature is not finite; expected finite ones");
  check(options);
  const Matrix matrix = matrix_of(features, truth);
  const Booster booster = booster_of(matrix, options, seed);
  for (unsigned round = 0; round < options.rounds; ++round) {
    check_call(XGBoosterUpdateOneIter(booster.get(), static_cast<int>(round), matrix.get()));
    report_progress(progress, round + 1, options.rounds, fmt::format("round {} of {} of trees", round + 1, options.rounds));
  }
  return trees_of(booster, features.size() / truth.size(), options.depth);
}

}  // namespace tactile::model
