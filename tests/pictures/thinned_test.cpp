#include "tactile/pictures/thinned.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile::pictures {
namespace {

TEST(Thinned, KeepsFewPointsAsTheyAre) {
  const std::vector<PlotPoint> points{{0, 1}, {3, 2}, {7, 0}};
  EXPECT_EQ(thinned(points, 0, 10, 100), points);
}

TEST(Thinned, KeepsFirstLeastLargestAndLastOfEachColumn) {
  const std::vector<PlotPoint> points{{0.0, 5}, {0.1, 6}, {0.2, 9}, {0.3, 4}, {0.4, 1}, {0.5, 2}, {0.9, 3}, {1.0, 7}, {1.9, 7}};
  const std::vector<PlotPoint> expected{{0.0, 5}, {0.2, 9}, {0.4, 1}, {0.9, 3}, {1.0, 7}, {1.9, 7}};
  EXPECT_EQ(thinned(points, 0, 2, 2), expected);
}

TEST(Thinned, LosesNoExtremeAndStaysSmall) {
  std::vector<PlotPoint> points;
  for (int i = 0; i < 100'000; ++i) points.push_back({i * 1e-5, std::sin(i * 0.01) + (i == 77'777 ? 10 : 0)});
  const auto seen = thinned(points, 0, 1, 50);
  EXPECT_LE(seen.size(), 50U * 5 + 2);
  EXPECT_TRUE(std::any_of(seen.begin(), seen.end(), [](const PlotPoint& point) { return point.y > 9; }));
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; }));
}

TEST(Thinned, ReachesBothEdgesAndLeavesWhatIsBeyond) {
  const std::vector<PlotPoint> points{{-2, 1}, {-1, 2}, {0.5, 3}, {2, 4}, {3, 5}};
  const std::vector<PlotPoint> expected{{-1, 2}, {0.5, 3}, {2, 4}};
  EXPECT_EQ(thinned(points, 0, 1, 10), expected);
}

TEST(Thinned, KeepsAGap) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PlotPoint> points{{0.1, 1}, {0.2, gap}, {0.3, 2}};
  const auto seen = thinned(points, 0, 1, 1);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_TRUE(std::isnan(seen[1].y));
  EXPECT_TRUE(thinned({}, 0, 1, 10).empty());
}

}  // namespace
}  // namespace tactile::pictures
