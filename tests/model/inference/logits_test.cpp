#include "tactile/model/inference/logits.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::model {
namespace {

TEST(IsClose, IsTrueBelowATenThousandthBetweenTheTwoLargest) {
  EXPECT_TRUE(is_close({1.0F, -5.0F, 1.00005F}));
  EXPECT_TRUE(is_close({2.0F, 2.0F, 2.0F}));
  EXPECT_FALSE(is_close({1.0F, 1.0F, 1.0002F}));
  EXPECT_FALSE(is_close({-3.0F, -3.0F, 0.0F}));
}

TEST(Probabilities, AreTheSoftmaxOfTheLogits) {
  const Probabilities p = probabilities_of({1.0F, 2.0F, -1.0F});
  const double sum = std::exp(1.0) + std::exp(2.0) + std::exp(-1.0);
  EXPECT_NEAR(p[0], std::exp(1.0) / sum, 1e-7);
  EXPECT_NEAR(p[1], std::exp(2.0) / sum, 1e-7);
  EXPECT_NEAR(p[2], std::exp(-1.0) / sum, 1e-7);
}

TEST(Probabilities, AreEvenerAtAHigherTemperature) {
  const Probabilities p = probabilities_of({1.0F, 2.0F, -1.0F}, 2);
  const double sum = std::exp(0.5) + std::exp(1.0) + std::exp(-0.5);
  EXPECT_NEAR(p[0], std::exp(0.5) / sum, 1e-7);
  EXPECT_NEAR(p[1], std::exp(1.0) / sum, 1e-7);
  EXPECT_NEAR(p[2], std::exp(-0.5) / sum, 1e-7);
}

TEST(Probabilities, AreRightForLogitsOfAnySize) {
  const Probabilities huge = probabilities_of({3e38F, -3e38F, 3e38F});
  EXPECT_EQ(huge, (Probabilities{0.5F, 0.0F, 0.5F}));
  const Probabilities low = probabilities_of({-1000.0F, -1001.0F, -2000.0F});
  EXPECT_NEAR(low[0], 1 / (1 + std::exp(-1.0)), 1e-6);
}

TEST(Probabilities, OfTenThousandAreOneAndNothing) {
  EXPECT_EQ(probabilities_of({1e4F, -1e4F, 0.0F}), (Probabilities{1, 0, 0}));
  EXPECT_EQ(probabilities_of({-1e4F, -1e4F, 1e4F}), (Probabilities{0, 0, 1}));
  EXPECT_EQ(verdict_of({-1e4F, 1e4F, 0.0F}), Touch::press);
  // Their difference counts, however far they lie from 0; neighbours of 10 000 in float32 are 1 / 1024 apart.
  const Probabilities close = probabilities_of({1e4F + 0.5F, -1e4F, 1e4F});
  EXPECT_NEAR(close[0], 1 / (1 + std::exp(-0.5)), 1e-7);
  EXPECT_NEAR(close[2], 1 / (1 + std::exp(0.5)), 1e-7);
  EXPECT_TRUE(is_close({1e4F, -1e4F, 1e4F}));
  EXPECT_FALSE(is_close({1e4F, -1e4F, std::nextafter(1e4F, 0.0F)}));
}

}  // namespace
}  // namespace tactile::model
