#include "tactile/model/inference/boosted_trees.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

/// Two rounds of depth 1: each tree compares one feature.
BoostedTrees small_trees() {
  return {2, 1, {{0, 1}, {1, 2}, {0, 3}, {1, 0}, {0, 0}, {1, 5}}, {1, 2, 3, 4, 5, 6, 10, 20, 30, 40, 50, 60}};
}

TEST(BoostedTrees, AddWhatTheTreesOfAClassAnswer) {
  const BoostedTrees trees = small_trees();
  EXPECT_EQ(trees.rounds(), 2U);
  // 0.5 < 1, 2 >= 2, 0.5 < 3; then 2 >= 0, 0.5 >= 0, 2 < 5.
  EXPECT_EQ(trees.logits(std::vector<float>{0.5F, 2}), (Logits{1 + 20, 4 + 40, 5 + 50}));
  // A feature that equals the threshold goes right.
  EXPECT_EQ(trees.logits(std::vector<float>{1, -1}), (Logits{2 + 10, 3 + 40, 5 + 50}));
}

TEST(BoostedTrees, SendANaNToTheRight) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(small_trees().logits(std::vector<float>{nan, nan}), (Logits{2 + 20, 4 + 40, 6 + 60}));
}

TEST(BoostedTrees, RefuseWhatIsNoEnsemble) {
  EXPECT_THROW(BoostedTrees(2, 1, {}, {}), Error);
  EXPECT_THROW(BoostedTrees(2, 0, {}, {1, 2, 3}), Error);
  EXPECT_THROW(BoostedTrees(2, 1, {{0, 0}, {0, 0}}, {1, 2, 3, 4, 5, 6}), Error);
  EXPECT_THROW(BoostedTrees(2, 1, {{0, 0}, {0, 0}, {2, 0}}, {1, 2, 3, 4, 5, 6}), Error);
  EXPECT_THROW(BoostedTrees(2, 1, {{0, 0}, {0, 0}, {1, std::numeric_limits<float>::infinity()}}, {1, 2, 3, 4, 5, 6}), Error);
  EXPECT_THROW(BoostedTrees(2, 1, {{0, 0}, {0, 0}, {1, 0}}, {1, 2, 3, 4, 5, std::numeric_limits<float>::quiet_NaN()}), Error);
  EXPECT_THROW(small_trees().logits(std::vector<float>{1}), Error);
}

}  // namespace
}  // namespace tactile::model
