#include "tactile/model/training/fit_trees.hpp"

#include <gtest/gtest.h>
#include <xgboost/c_api.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::model {
namespace {

constexpr std::size_t columns = 5;

/// Samples whose class is the part of a ring, which no straight line separates; the other features are noise.
struct Rings {
  std::vector<float> features;
  std::vector<Touch> truth;

  explicit Rings(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    const auto any = [&] { return static_cast<float>(random.below(2'001)) / 1'000 - 1; };
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < columns; ++k) features.push_back(any());
      const float radius = std::hypot(features[i * columns], features[i * columns + 1]);
      truth.push_back(all_touches[radius < 0.5F ? 0 : radius < 0.9F ? 1 : 2]);
    }
  }
  std::span<const float> of(std::size_t i) const { return std::span(features).subspan(i * columns, columns); }
};

TEST(FitTrees, PredictsWhatXGBoostPredicts) {
  const Rings rings(400, 1);
  for (const unsigned depth : {1U, 4U}) {
    const TreesOptions options{.rounds = 30, .depth = depth};
    const BoostedTrees trees = fit_trees(rings.features, rings.truth, options, 7);

    DMatrixHandle matrix = nullptr;
    ASSERT_EQ(XGDMatrixCreateFromMat(rings.features.data(), rings.truth.size(), columns, std::numeric_limits<float>::quiet_NaN(),
                                     &matrix),
              0);
    std::vector<float> labels;
    for (const Touch touch : rings.truth) labels.push_back(static_cast<float>(touch));
    ASSERT_EQ(XGDMatrixSetFloatInfo(matrix, "label", labels.data(), labels.size()), 0);
    BoosterHandle booster = nullptr;
    ASSERT_EQ(XGBoosterCreate(&matrix, 1, &booster), 0);
    for (const auto& [name, value] : xgboost_parameters(options, 7)) XGBoosterSetParam(booster, name.c_str(), value.c_str());
    for (unsigned round = 0; round < options.rounds; ++round)
      ASSERT_EQ(XGBoosterUpdateOneIter(booster, static_cast<int>(round), matrix), 0);
    bst_ulong length = 0;
    const float* probabilities = nullptr;
    ASSERT_EQ(XGBoosterPredict(booster, matrix, 0, 0, 0, &length, &probabilities), 0);
    ASSERT_EQ(length, rings.truth.size() * touch_count);
    for (std::size_t i = 0; i < rings.truth.size(); ++i) {
      const Probabilities ours = probabilities_of(trees.logits(rings.of(i)));
      for (std::size_t k = 0; k < touch_count; ++k) ASSERT_NEAR(ours[k], probabilities[i * touch_count + k], 1e-6) << depth;
    }
    XGBoosterFree(booster);
    XGDMatrixFree(matrix);
  }
}

TEST(FitTrees, LearnsWhatNoStraightLineSeparates) {
  const Rings training(1'500, 1), test(500, 2);
  const BoostedTrees trees = fit_trees(training.features, training.truth);
  EXPECT_EQ(trees.rounds(), 150U);
  std::size_t right = 0;
  for (std::size_t i = 0; i < test.truth.size(); ++i) right += verdict_of(trees.logits(test.of(i))) == test.truth[i] ? 1U : 0U;
  EXPECT_GT(right, 460U);
}

TEST(FitTrees, GivesTheSameTreesAgainAndOthersWithAnotherSeed) {
  const Rings rings(300, 1);
  const TreesOptions options{.rounds = 5};
  const Logits first = fit_trees(rings.features, rings.truth, options).logits(rings.of(0));
  EXPECT_EQ(fit_trees(rings.features, rings.truth, options).logits(rings.of(0)), first);
  EXPECT_NE(fit_trees(rings.features, rings.truth, options, 2).logits(rings.of(0)), first);
}

TEST(FitTrees, RefusesSamplesAndOptionsOutOfRange) {
  const Rings rings(30, 1);
  EXPECT_THROW(fit_trees({}, {}), Error);
  EXPECT_THROW(fit_trees(std::span(rings.features).first(7), rings.truth), Error);
  EXPECT_THROW(fit_trees(rings.features, rings.truth, {.rounds = 0}), Error);
  EXPECT_THROW(fit_trees(rings.features, rings.truth, {.depth = 9}), Error);
  EXPECT_THROW(fit_trees(rings.features, rings.truth, {.learning_rate = 0}), Error);
  std::vector<float> damaged = rings.features;
  damaged[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(fit_trees(damaged, rings.truth), Error);
}

}  // namespace
}  // namespace tactile::model
