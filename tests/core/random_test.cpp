#include "tactile/core/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace tactile {
namespace {

TEST(Random, IsTheSameForTheSameSeed) {
  Random a(7), b(7), c(8);
  EXPECT_EQ(a.bits(), b.bits());
  EXPECT_NE(a.bits(), c.bits());
}

TEST(Random, BelowIsEven) {
  Random random(1);
  std::array<int, 6> seen{};
  for (int i = 0; i < 60'000; ++i) ++seen[random.below(6)];
  for (const int count : seen) EXPECT_NEAR(count, 10'000, 500);
}

TEST(Random, NormalHasMeanZeroAndDeviationOne) {
  Random random(2);
  double sum = 0, squares = 0;
  constexpr int draws = 100'000;
  for (int i = 0; i < draws; ++i) {
    const double value = random.normal();
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / draws, 0.0, 0.02);
  EXPECT_NEAR(squares / draws, 1.0, 0.02);
}

TEST(Random, PoissonHasItsMeanSmallAndLarge) {
  Random random(3);
  for (const double mean : {0.0, 0.3, 12.0, 5000.0}) {
    double sum = 0;
    for (int i = 0; i < 20'000; ++i) sum += static_cast<double>(random.poisson(mean));
    EXPECT_NEAR(sum / 20'000, mean, 5 * std::sqrt(mean / 20'000) + 1e-12);
  }
}

TEST(Random, ShuffleKeepsEveryValue) {
  Random random(4);
  std::vector<int> values(100), sorted(100);
  std::iota(values.begin(), values.end(), 0);
  sorted = values;
  random.shuffle(values);
  EXPECT_NE(values, sorted);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, sorted);
}

TEST(SeedFor, DiffersByNameAndBySeed) {
  EXPECT_EQ(seed_for(1, {"fan", "01"}), seed_for(1, {"fan", "01"}));
  EXPECT_NE(seed_for(1, {"fan", "01"}), seed_for(1, {"fan", "02"}));
  EXPECT_NE(seed_for(1, {"fan", "01"}), seed_for(2, {"fan", "01"}));
  EXPECT_NE(seed_for(1, {"ab", "c"}), seed_for(1, {"a", "bc"}));
}

}  // namespace
}  // namespace tactile
