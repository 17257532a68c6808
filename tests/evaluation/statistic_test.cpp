#include "tactile/evaluation/statistic.hpp"

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

TEST(BinomialBounds, AreThoseOfTheExactInterval) {
  // Quantiles of the beta distribution, by SciPy.
  const auto expect = [](double count, double n, double confidence, double low, double high) {
    const auto bounds = binomial_bounds(count, n, confidence);
    EXPECT_NEAR(bounds.first, low, 1e-9) << count << " of " << n;
    EXPECT_NEAR(bounds.second, high, 1e-9) << count << " of " << n;
  };
  expect(0, 10, 0.95, 0, 0.3084971078187607);
  expect(1, 10, 0.95, 0.0025285785444617865, 0.4450161170281954);
  expect(5, 10, 0.95, 0.18708602844739855, 0.8129139715526015);
  expect(10, 10, 0.95, 0.6915028921812392, 1);
  expect(2.5, 9.75, 0.95, 0.0452623480844581, 0.6168492059286586);
  expect(37, 200, 0.99, 0.12003614826512815, 0.26546828326787136);
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
