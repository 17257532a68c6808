#include "tactile/core/straight_line.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tactile {
namespace {

TEST(StraightLine, PassesThroughPointsOnALine) {
  const std::vector<WeightedPoint> points{{1, 5, 1}, {2, 7, 4}, {4, 11, 0.5}};
  const StraightLine line = line_through(points);
  EXPECT_DOUBLE_EQ(line.gradient, 2);
  EXPECT_DOUBLE_EQ(line.at(0), 3);
}

TEST(StraightLine, CountsAPointOfWeightTwoAsTwoPoints) {
  const StraightLine once = line_through(std::vector<WeightedPoint>{{0, 0, 1}, {1, 0, 1}, {2, 3, 2}});
  const StraightLine twice = line_through(std::vector<WeightedPoint>{{0, 0, 1}, {1, 0, 1}, {2, 3, 1}, {2, 3, 1}});
  EXPECT_DOUBLE_EQ(once.gradient, twice.gradient);
  EXPECT_DOUBLE_EQ(once.gradient, 4.5 / 2.75);  // sums about the means, x = 1.25 and y = 1.5
  EXPECT_DOUBLE_EQ(once.at(0), twice.at(0));
  EXPECT_DOUBLE_EQ(once.weighted_xx, 2.75);
}

TEST(StraightLine, IsLevelWhereAllPointsHaveOneX) {
  const StraightLine line = line_through(std::vector<WeightedPoint>{{3, 1, 1}, {3, 2, 3}});
  EXPECT_EQ(line.gradient, 0);
  EXPECT_DOUBLE_EQ(line.at(100), 1.75);
}

TEST(StraightLine, OfNoWeightIsZero) { EXPECT_EQ(line_through(std::vector<WeightedPoint>{{1, 5, 0}}).at(7), 0); }

}  // namespace
}  // namespace tactile
