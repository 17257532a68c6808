#include "tactile/evaluation/confidence_interval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/core/random.hpp"

namespace tactile::evaluation {
namespace {

TEST(PoissonUpperBound, IsThatOfTheExactInterval) {
  // Half of the quantile of chi-squared at 0.975 with 2 (count + 1) degrees of freedom, as SciPy's gamma functions give it.
  EXPECT_NEAR(poisson_upper_bound(0), 3.688879454, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(1), 5.571643391, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(10), 18.390356042, 1e-8);
  EXPECT_NEAR(poisson_upper_bound(100), 121.626793792, 1e-7);
  EXPECT_NEAR(poisson_upper_bound(0, 0.9), 2.995732274, 1e-8) << "the rule of three";
  const double of_many = poisson_upper_bound(100'000);
  EXPECT_NEAR(of_many, 100'000 + 1.96 * 316.23, 5);
}

TEST(MeanOverObjects, LeavesOutObjectsThatGiveNothing) {
  const auto statistic = mean_over_objects([](std::span<const std::size_t> runs) -> std::optional<double> {
    if (runs.empty()) return std::nullopt;
    return static_cast<double>(runs.front());
  });
  EXPECT_DOUBLE_EQ(*statistic({{2}, {}, {4}}), 3);
  EXPECT_FALSE(statistic({{}, {}}).has_value());
}

}  // namespace
}  // namespace tactile::evaluation
