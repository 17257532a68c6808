#include "tactile/characterise/noise_model.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tactile/core/random.hpp"

namespace tactile::characterise {
namespace {

TEST(MomentsOf, AreThoseOfPoissonCountsForEqualPixelsOfShapeOne) {
  for (const double mean : {0.1, 1.0, 30.0}) {
    const WindowMoments moments = moments_of({.shape = 1, .spread = 0}, mean);
    EXPECT_NEAR(moments.differences, 1, 1e-9) << mean;
    EXPECT_NEAR(moments.products, 0, 1e-9) << mean;
    EXPECT_NEAR(silent_share({.shape = 1, .spread = 0}, std::array{mean}), std::exp(-mean), 1e-9) << mean;
  }
}

TEST(MomentsOf, HaveTheVarianceOfLogNormalRates) {
  // Var(rate) / mean^2 = exp(spread^2) - 1
  EXPECT_NEAR(moments_of({.shape = 1, .spread = 0.5}, 2).products, std::expm1(0.25), 2e-3);
  EXPECT_NEAR(moments_of({.shape = 1, .spread = 0.5}, 2).differences, 1, 2e-3);
}

/// Counts of renewal processes in two windows, drawn interval by interval.
WindowSums drawn(int shape, double spread, double mean, int pixels, std::uint64_t seed) {
  Random random(seed);
  WindowSums sums;
  for (int i = 0; i < pixels; ++i) {
    const double rate = mean * std::exp(spread * random.normal() - spread * spread / 2);
    std::uint32_t n1 = 0, n2 = 0;
    for (double t = -30 / rate;;) {
      for (int k = 0; k < shape; ++k) t += random.exponential() / (rate * shape);
      if (t >= 2) break;
      if (t >= 0) ++(t < 1 ? n1 : n2);
    }
    sums.add(n1, n2);
  }
  return sums;
}

TEST(SilentShare, OfShapeTwoDependsOnHowOftenARecordingBegins) {
  // Every second event of a Poisson process of rate 2 m, from a random one on: exp(-2 m) (1 + m).
  const auto once = [](double m) { return std::exp(-2 * m) * (1 + m); };
  const NoiseModel model{.shape = 2, .spread = 0};
  EXPECT_NEAR(silent_share(model, std::array{3.0}), once(3), 1e-9);
  EXPECT_NEAR(silent_share(model, std::array{1.0, 1.0, 1.0}), once(1) * once(1) * once(1), 1e-9);
  EXPECT_EQ(silent_share(model, {}), 1);
}

TEST(NoiseModel, IsThatFromWhichCountsWereDrawn) {
  for (const int shape : {1, 2, 4}) {
    for (const double spread : {0.0, 0.3, 0.7}) {
      const NoiseModel model = noise_model(drawn(shape, spread, 1.2, 100'000, 7));
      EXPECT_NEAR(model.shape, shape, 0.06 * shape) << spread;
      EXPECT_NEAR(model.spread, spread, spread == 0 ? 0.08 : 0.02) << shape;
    }
  }
}

TEST(NoiseModel, LiesBetweenWholeShapes) {
  WindowSums sums = drawn(2, 0.4, 1.5, 100'000, 3);
  sums += drawn(3, 0.4, 1.5, 100'000, 4);
  const double shape = noise_model(sums).shape;
  EXPECT_GT(shape, 2.1);
  EXPECT_LT(shape, 2.9);
}

TEST(NoiseModel, HasAShapeBelowOneForBursts) {
  WindowSums sums;  // pairs of events at once
  Random random(5);
  for (int i = 0; i < 100'000; ++i)
    sums.add(static_cast<std::uint32_t>(2 * random.poisson(0.5)), static_cast<std::uint32_t>(2 * random.poisson(0.5)));
  EXPECT_NEAR(noise_model(sums).shape, 0.5, 0.02);
}

TEST(NoiseModel, OfNoEventsIsPoisson) {
  const NoiseModel model = noise_model({});
  EXPECT_EQ(model.shape, 1);
  EXPECT_EQ(model.spread, 0);
}

}  // namespace
}  // namespace tactile::characterise
