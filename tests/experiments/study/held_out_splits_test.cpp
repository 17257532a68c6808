#include "tactile/experiments/study/held_out_splits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"

namespace tactile::study {
namespace {

std::vector<std::string> ten() { return {"j", "b", "c", "d", "e", "f", "g", "h", "i", "a"}; }

TEST(AllSplits, AreThe252WaysToLeaveFiveOfTenOut) {
  const auto splits = all_splits(ten(), 5);
  ASSERT_EQ(splits.size(), 252U);
  std::set<std::vector<std::string>> different;
  for (const HeldOutSplit& split : splits) {
    EXPECT_EQ(split.held_out.size(), 5U);
    EXPECT_TRUE(std::is_sorted(split.held_out.begin(), split.held_out.end()));
    different.insert(split.held_out);
  }
  EXPECT_EQ(different.size(), 252U);
  EXPECT_EQ(splits.front().name, "split-001");
  EXPECT_EQ(splits.front().held_out, (std::vector<std::string>{"a", "b", "c", "d", "e"}));
  EXPECT_EQ(splits.back().name, "split-252");
  EXPECT_EQ(splits.back().held_out, (std::vector<std::string>{"f", "g", "h", "i", "j"}));
}

TEST(AllSplits, OneOfThree) {
  const auto splits = all_splits({"a", "b", "c"}, 1);
  ASSERT_EQ(splits.size(), 3U);
  EXPECT_EQ(splits[1].held_out, std::vector<std::string>{"b"});
}

TEST(AllSplits, SomethingMustBeLeftToLearnFrom) {
  EXPECT_THROW(all_splits({"a", "b"}, 2), Error);
  EXPECT_THROW(all_splits({"a", "a", "b"}, 2), Error);
  EXPECT_THROW(all_splits({"a", "b"}, 0), Error);
}

TEST(DrawnSplits, AreTheSameForTheSameSeedAndGrowWithTheirNumber) {
  const auto all = all_splits(ten(), 5);
  const auto names = [&](std::size_t count, std::uint64_t seed) {
    std::set<std::string> drawn;
    for (const HeldOutSplit& split : drawn_splits(all, count, seed)) drawn.insert(split.name);
    return drawn;
  };
  EXPECT_EQ(names(8, 1).size(), 8U);
  EXPECT_EQ(names(8, 1), names(8, 1));
  EXPECT_NE(names(8, 1), names(8, 2));
  const auto few = names(8, 1), more = names(20, 1);
  EXPECT_TRUE(std::includes(more.begin(), more.end(), few.begin(), few.end()));
  EXPECT_EQ(names(1000, 1).size(), 252U);
  EXPECT_TRUE(names(0, 1).empty());
}

}  // namespace
}  // namespace tactile::study
