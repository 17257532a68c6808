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

}  // namespace
}  // namespace tactile::results
