#include "tactile/results/figure_text.hpp"

#include <gtest/gtest.h>

namespace tactile::results {
namespace {

TEST(FigureText, HasTheIntervalIfThereIsOne) {
  EXPECT_EQ(figure_text({0.946, 0.913, 0.967, 10}, 100, 1), "94.6 [91.3, 96.7]");
  EXPECT_EQ(figure_text({.value = 2.345}, 1, 2), "2.35");
  EXPECT_EQ(figure_text({}, 100, 1), "-");
  EXPECT_EQ(figure_text({.value = 1, .low = 0.5}, 1, 1), "1.0 [0.5, ?]");
  EXPECT_EQ(interval_text({-0.4, -1.8, 0.9, 10}, 1, 1), "[-1.8, 0.9]");
  EXPECT_EQ(interval_text({.value = 1}, 1, 1), "");
}

TEST(FigureText, NamesAnIntervalWithoutBounds) {
  const Figure wide{28.3, 1e-4, 7'854'364.7, 3};
  EXPECT_FALSE(is_bounded(wide));
  EXPECT_EQ(figure_text(wide, 1, 1), "28.3 [not bounded]");
  EXPECT_EQ(text_of(wide, " per minute"), "28.3 per minute [not bounded]");
  EXPECT_TRUE(is_bounded({0, 0, 11, 3})) << "no alarm, and what its count allows";
  EXPECT_TRUE(is_bounded({1, 0.1, 1e6, 3})) << "the low bound says something";
  EXPECT_TRUE(is_bounded({1, 0, 900, 3}));
}

}  // namespace
}  // namespace tactile::results
