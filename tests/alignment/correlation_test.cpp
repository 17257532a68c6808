#include "tactile/alignment/correlation.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tactile/core/random.hpp"

namespace tactile::alignment {
namespace {

TEST(Correlations, AreTheSumsOfProductsAtEveryLag) {
  Random random(3);
  for (const auto& [n, m] : {std::pair<std::size_t, std::size_t>{1, 1}, {5, 9}, {64, 64}, {37, 3}}) {
    std::vector<double> a(n), b(m);
    for (double& value : a) value = random.normal();
    for (double& value : b) value = 100 * random.normal();
    const std::vector<double> found = correlations(a, b);
    ASSERT_EQ(found.size(), n + m - 1);
    for (std::size_t k = 0; k < found.size(); ++k) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        if (i + k >= n - 1 && i + k - (n - 1) < m) sum += a[i] * b[i + k - (n - 1)];
      }
      EXPECT_NEAR(found[k], sum, 1e-9) << n << " on " << m << " at " << k;
    }
  }
}

TEST(Correlations, PeakWhereOneSignalLiesInTheOther) {
  const std::vector<double> a{1, -2, 3}, b{0, 0, 0, 0, 1, -2, 3, 0};
  const std::vector<double> found = correlations(a, b);
  const auto peak = std::max_element(found.begin(), found.end()) - found.begin();
  EXPECT_EQ(peak - 2, 4) << "a is moved by four to lie on b";
}

TEST(Correlations, OfNothingAreNone) {
  EXPECT_TRUE(correlations({}, std::vector<double>{1.0}).empty());
  EXPECT_TRUE(correlations(std::vector<double>{1.0}, {}).empty());
}

}  // namespace
}  // namespace tactile::alignment
