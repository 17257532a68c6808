#include "tactile/alignment/main_direction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tactile::alignment {
namespace {

TEST(MainDirection, IsTheDirectionOfMostOfTheVectors) {
  // 1 and -3 along (0.6, 0, 0.8), and 0.5 across it.
  const MainDirection main = main_direction(std::vector<std::array<double, 3>>{{0.6, 0, 0.8}, {-1.8, 0, -2.4}, {0, 0.5, 0}});
  EXPECT_NEAR(std::abs(main.axis[0]), 0.6, 1e-12);
  EXPECT_NEAR(main.axis[1], 0, 1e-12);
  EXPECT_NEAR(main.axis[2], main.axis[0] * 4 / 3, 1e-12);
  EXPECT_NEAR(main.along, 10, 1e-12);
  EXPECT_NEAR(main.across, 0.25, 1e-12);
}

TEST(MainDirection, IsUpwardsWhereNothingMoves) {
  EXPECT_EQ(main_direction(std::vector<std::array<double, 3>>(5)).axis, (std::array<double, 3>{0, 0, 1}));
  EXPECT_EQ(main_direction({}).along, 0);
}

}  // namespace
}  // namespace tactile::alignment
