#include "tactile/evaluation/episodes.hpp"

#include <gtest/gtest.h>

#include "support/verdict_row.hpp"

namespace tactile::evaluation {
namespace {

using test::verdict_row;

TEST(Episodes, AreMaximalRowsOfOneVerdictOtherThanNone) {
  const std::vector<Episode> expected{{Touch::press, 1, 2}, {Touch::slip, 3, 3}, {Touch::press, 5, 6}};
  EXPECT_EQ(episodes_in(verdict_row(".pps.pp")), expected);
}

TEST(Episodes, ReachBothEndsOfTheRun) {
  const std::vector<Episode> expected{{Touch::slip, 0, 3}};
  EXPECT_EQ(episodes_in(verdict_row("ssss")), expected);
}

TEST(Episodes, AreNoneIfNothingIsPredicted) {
  EXPECT_TRUE(episodes_in(verdict_row("....")).empty());
  EXPECT_TRUE(episodes_in({}).empty());
}

}  // namespace
}  // namespace tactile::evaluation
