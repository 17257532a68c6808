#include "tactile/core/robust_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace tactile {
namespace {

using Values = std::vector<double>;

TEST(Median, TakesTheLowerTheUpperOrTheMeanOfTwoInTheMiddle) {
  const Values odd{5, 1, 3}, even{4, 1, 3, 2};
  for (const double middle : {lower_median(odd), median(odd)}) EXPECT_EQ(middle, 3);
  EXPECT_EQ(lower_median(even), 2);
  EXPECT_EQ(median(even), 2.5);
  EXPECT_EQ(even, (Values{4, 1, 3, 2}));
  EXPECT_EQ(median<std::int64_t>(std::vector<std::int64_t>{9, 7}), 8);
  EXPECT_EQ(median<std::int64_t>(std::vector<std::int64_t>{7, 10}), 8);
}

TEST(Median, IsZeroOfNothing) {
  for (const double middle : {lower_median({}), median({}), quantile({}, 0.5), nearest_rank_quantile({}, 0.5)})
    EXPECT_EQ(middle, 0);
}

TEST(Median, OfDistancesGivesTheDeviationOfMostValues) {
  const Values values{9, 10, 11, 12, 1000};
  EXPECT_EQ(median(distances_from(median(values), values)), 1);
}

TEST(ValueOfRank, OrdersAsItIsAskedTo) {
  const Values values{5, 1, 3};
  EXPECT_EQ(value_of_rank(values, 0), 1);
  EXPECT_EQ((value_of_rank<double, std::greater<>>(values, 0)), 5);
}

TEST(Quantile, InterpolatesBetweenNeighbours) {
  EXPECT_DOUBLE_EQ(quantile(Values{3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile(Values{4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile(Values{0, 10}, 0.025), 0.25);
  EXPECT_DOUBLE_EQ(quantile(Values{7}, 0.975), 7);
  EXPECT_DOUBLE_EQ(quantile(Values{1, 2}, 1), 2);
}

TEST(Quantile, OfNearestRankIsOneOfTheValues) {
  const Values values{10, 40, 20, 30};
  EXPECT_EQ(nearest_rank_quantile(values, 0), 10);
  EXPECT_EQ(nearest_rank_quantile(values, 0.25), 10);
  EXPECT_EQ(nearest_rank_quantile(values, 0.26), 20);
  EXPECT_EQ(nearest_rank_quantile(values, 0.95), 40);
  EXPECT_EQ(nearest_rank_quantile(values, 1), 40);
}

}  // namespace
}  // namespace tactile
