#include "tactile/core/measured.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace tactile {
namespace {

TEST(MeanOf, HasTheStandardErrorAsItsUncertainty) {
  const Measured mean = mean_of(std::array{1.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(mean.value, 2);
  EXPECT_DOUBLE_EQ(mean.uncertainty, 1 / std::sqrt(3.0));
  EXPECT_TRUE(std::isinf(mean_of(std::array{4.0}).uncertainty));
  EXPECT_EQ(mean_of({}).value, 0);
}

TEST(RatioOf, IsTheRatioOfTheSumsWithTheScatterOfTheParts) {
  // 10 in 2 s and 14 in 4 s: r = 4, residuals 2 and -2, u^2 = 2 * (4 + 4) / 36.
  const Measured ratio = ratio_of(std::array{CountPart{10, 2}, CountPart{14, 4}});
  EXPECT_DOUBLE_EQ(ratio.value, 4);
  EXPECT_DOUBLE_EQ(ratio.uncertainty, 4.0 / 6);
  EXPECT_EQ(ratio_of(std::array{CountPart{12, 3}}).value, 4);
  EXPECT_TRUE(std::isinf(ratio_of(std::array{CountPart{12, 3}}).uncertainty));
}

TEST(Combined, WeighsByTheUncertainties) {
  const Measured together = combined(std::array{Measured{10, 1}, Measured{10.5, 0.5}});
  EXPECT_DOUBLE_EQ(together.value, 10.4);
  EXPECT_DOUBLE_EQ(together.uncertainty, 1 / std::sqrt(5.0));
}

TEST(Combined, GrowsItsUncertaintyIfTheValuesDisagree) {
  const Measured together = combined(std::array{Measured{10, 1}, Measured{20, 1}});
  EXPECT_DOUBLE_EQ(together.value, 15);
  EXPECT_DOUBLE_EQ(together.uncertainty, std::sqrt(50.0) / std::sqrt(2.0));  // chi^2 = 50 of one degree of freedom
  EXPECT_DOUBLE_EQ(combined(std::array{Measured{3, 2}}).uncertainty, 2);
}

}  // namespace
}  // namespace tactile
