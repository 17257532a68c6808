#include "tactile/labels/onset_scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tactile/core/random.hpp"

namespace tactile::labels {
namespace {

/// The formula of `best_rise` at given b and c, bin by bin in long double. x is the middle of a bin.
long double log_likelihood(const std::vector<std::uint32_t>& counts, double base, double b, double c) {
  long double sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const long double rate = base + b + c * (static_cast<long double>(i) + 0.5L);
    sum += static_cast<long double>(counts[i]) * std::log(rate) - rate;
  }
  return sum;
}

/// The place in [0, high] of the maximum of a concave function, by ternary search.
template <class Function>
double place_of_maximum(double high, const Function& function) {
  double low = 0;
  for (int step = 0; step < 45; ++step) {
    const double third = (high - low) / 3;
    if (function(low + third) < function(high - third)) {
      low += third;
    } else {
      high -= third;
    }
  }
  return (low + high) / 2;
}

/// Its maximum over b, c >= 0. It is concave in both.
long double best_by_search(const std::vector<std::uint32_t>& counts, double base) {
  const double most = 1.0 + *std::max_element(counts.begin(), counts.end());
  const auto best_c = [&](double b) {
    return place_of_maximum(most, [&](double c) { return log_likelihood(counts, base, b, c); });
  };
  const auto of_b = [&](double b) { return log_likelihood(counts, base, b, best_c(b)); };
  return of_b(place_of_maximum(most, of_b));
}

double best_of(const std::vector<std::uint32_t>& counts, double base) {
  return best_rise(filled_bins(counts), 0, counts.size(), base);
}

TEST(BestRise, IsTheMaximumThatASearchFinds) {
  Random random(4);
  for (const auto& [base, b, c] :
       {std::array{0.5, 3.0, 0.0}, {0.5, 0.0, 0.2}, {2.0, 1.0, 0.05}, {0.01, 0.0, 2.0}, {5.0, 40.0, 3.0}}) {
    std::vector<std::uint32_t> counts;
    for (int i = 0; i < 60; ++i) counts.push_back(static_cast<std::uint32_t>(random.poisson(base + b + c * (i + 0.5))));
    const auto expected = static_cast<double>(best_by_search(counts, base));
    EXPECT_NEAR(best_of(counts, base), expected, 1e-3) << "an interval ends where the likelihood is 1.92 lower; base " << base;
  }
}

TEST(BestRise, OfAFlatRateIsTheClosedForm) {
  const std::vector<std::uint32_t> counts(50, 7);
  EXPECT_NEAR(best_of(counts, 2), 50 * (7 * std::log(7.0) - 7), 1e-6);
  EXPECT_NEAR(best_of(std::vector<std::uint32_t>(50, 0), 2), -100, 0.05) << "no rise: b and c are 0";
}

TEST(BestRise, StaysFiniteAtTheExtremes) {
  constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  for (const double base : {1e-9, 1.0, 1e6}) {
    for (const std::vector<std::uint32_t>& counts :
         {std::vector<std::uint32_t>{most}, std::vector<std::uint32_t>(2'000, most), std::vector<std::uint32_t>(2'000, 0),
          std::vector<std::uint32_t>{0, 0, 0, most}, std::vector<std::uint32_t>{1}}) {
      const double best = best_of(counts, base);
      EXPECT_TRUE(std::isfinite(best)) << base;
      EXPECT_GE(best, static_cast<double>(log_likelihood(counts, base, 0, 0)) - 1e-3 * (1 + std::abs(best)))
          << "a rise is never worse than none by more than the search leaves; base " << base;
      const Scan scan = scan_of(rise_likelihoods(Counts(counts).first(std::min<std::size_t>(counts.size(), 50)), base), 1);
      EXPECT_LE(scan.low, scan.best);
      EXPECT_GE(scan.high, scan.best);
    }
  }
}

TEST(ScanOf, HoldsEveryBinWithin192OfTheBestTimesTheDispersion) {
  const std::vector<double> likelihood{-9, -3.9, -5, -2, -2.1, -3.8, -9};
  const Scan scan = scan_of(likelihood, 1);
  EXPECT_EQ(scan.best, 3U);
  EXPECT_EQ(scan.low, 1U) << "bins between may be less likely";
  EXPECT_EQ(scan.high, 5U);
  EXPECT_EQ(scan_of(likelihood, 10).low, 0U);
}

}  // namespace
}  // namespace tactile::labels
