#include "tactile/live/minute.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace tactile::live {
namespace {

TEST(Minute, GivesTheStepsThatOneDoesNotHave) {
  Minute minute;
  minute.add(0.1, std::array{1.0});
  minute.add(0.2, std::array{std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(minute.since(0).dump(), "[[0.1,1.0],[0.2,null]]");
  EXPECT_EQ(minute.since(1).dump(), "[[0.2,null]]");
  EXPECT_EQ(minute.since(minute.next()).dump(), "[]");
}

TEST(Minute, RemembersAMinuteAndNoMore) {
  Minute minute;
  for (int i = 0; i < 2'000; ++i) minute.add(0.05 * i, std::array{static_cast<double>(i)});
  EXPECT_EQ(minute.next(), 2'000U);
  const nlohmann::json all = minute.since(0);
  ASSERT_EQ(all.size(), Minute::most_steps);
  EXPECT_EQ(all.front().at(1), 800.0);
  EXPECT_EQ(minute.since(1999).size(), 1U);
}

}  // namespace
}  // namespace tactile::live
