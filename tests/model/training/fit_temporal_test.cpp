#include "tactile/model/training/fit_temporal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/error_of.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/features/step_features.hpp"
#include "tactile/model/inference/temporal_network.hpp"

namespace tactile::model {
namespace {

/// Samples whose class is when their first feature rises: before step 5, before step 10, or later. No single step shows it.
struct Rises {
  std::vector<float> features;
  std::vector<Touch> truth;

  explicit Rises(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t rise = random.below(15);
      for (std::size_t step = 0; step < features::steps_of_history; ++step) {
        for (std::size_t k = 0; k < features::features_of_step; ++k)
          features.push_back(k == 0 ? (step >= rise ? 5.0F : 2.0F) : static_cast<float>(random.uniform(-1, 1)));
      }
      truth.push_back(all_touches[rise / 5]);
    }
  }
  std::span<const float> of(std::size_t i) const {
    return std::span(features).subspan(i * features::step_values, features::step_values);
  }
};

TEST(FitTemporal, PredictsWhatLibtorchPredictsWithDilatedConvolutions) {
  const Rises training(200, 1), test(300, 2);
  for (const unsigned channels : {1U, 7U, 32U, 64U}) {
    const TemporalOptions options{.channels = channels};
    const FittedTemporal fitted = fit_temporal(training.features, training.truth, options, {.epochs = 2});
    const TemporalNetwork network(options, fitted.weights);
    const auto expected = temporal_logits_by_libtorch(test.features, options, fitted.weights);
    ASSERT_EQ(expected.size(), test.truth.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Logits ours = network.logits(test.of(i));
      const float largest = std::max({std::abs(expected[i][0]), std::abs(expected[i][1]), std::abs(expected[i][2])});
      for (std::size_t k = 0; k < touch_count; ++k)
        ASSERT_NEAR(ours[k], expected[i][k], 1e-5F * largest) << channels << ", " << i;
    }
  }
}

TEST(FitTemporal, ReadsEveryStepOfTheHistory) {
  const Rises training(200, 1);
  const FittedTemporal fitted = fit_temporal(training.features, training.truth, {}, {.epochs = 2});
  const TemporalNetwork network({}, fitted.weights);
  for (std::size_t step = 0; step < features::steps_of_history; ++step) {
    std::vector<float> changed(training.of(0).begin(), training.of(0).end());
    for (std::size_t k = 0; k < features::features_of_step; ++k) changed[step * features::features_of_step + k] += 3;
    EXPECT_NE(network.logits(changed), network.logits(training.of(0))) << step;
  }
}

TEST(FitTemporal, LearnsWhatNoSingleStepShows) {
  const Rises training(1'500, 1), test(500, 2);
  const FittedTemporal fitted = fit_temporal(training.features, training.truth);
  ASSERT_EQ(fitted.history.size(), 10U);
  EXPECT_LT(fitted.history.back().loss, fitted.history.front().loss);
  const TemporalNetwork network({}, fitted.weights);
  std::size_t right = 0;
  for (std::size_t i = 0; i < test.truth.size(); ++i) right += verdict_of(network.logits(test.of(i))) == test.truth[i] ? 1U : 0U;
  EXPECT_GT(right, 475U);
}

TEST(FitTemporal, GivesTheSameWeightsAgainAndOthersWithAnotherSeed) {
  const Rises rises(100, 1);
  const Weights first = fit_temporal(rises.features, rises.truth, {}, {.epochs = 2}).weights;
  EXPECT_EQ(fit_temporal(rises.features, rises.truth, {}, {.epochs = 2}).weights, first);
  EXPECT_NE(fit_temporal(rises.features, rises.truth, {}, {.seed = 2, .epochs = 2}).weights, first);
}

TEST(FitTemporal, RefusesSamplesAndOptionsOutOfRange) {
  const Rises rises(30, 1);
  EXPECT_THROW(fit_temporal({}, {}), Error);
  EXPECT_THROW(fit_temporal(std::span(rises.features).first(7), rises.truth), Error);
  EXPECT_THROW(fit_temporal(rises.features, rises.truth, {.channels = 65}), Error);
  EXPECT_THROW(fit_temporal(rises.features, rises.truth, {}, {.epochs = 0}), Error);
  EXPECT_NE(test::error_of([&] {
              fit_temporal(rises.features, rises.truth, {},
                           {.epochs = 50, .learning_rate = 1e9, .optimizer = OptimizerKind::sgd});
            }).find("try a smaller --lr"),
            std::string::npos);
  std::vector<float> damaged = rises.features;
  damaged[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(fit_temporal(damaged, rises.truth), Error);
}

}  // namespace
}  // namespace tactile::model
