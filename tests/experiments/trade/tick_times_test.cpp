#include "tactile/experiments/trade/tick_times.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::trade {
namespace {

TEST(TickTime, IsTheCountingAloneWhereTheGateCloses) {
  const TickTime tick{.counting = 2, .rendering = 30, .network = 400, .events = 99};
  EXPECT_DOUBLE_EQ(tick.total(std::nullopt), 432);
  EXPECT_DOUBLE_EQ(tick.total(100), 2);
  EXPECT_DOUBLE_EQ(tick.total(99), 432);
}

TEST(WriteTimes, ReadsBackTheSame) {
  const test::TemporaryFolder folder;
  const std::vector<TimesOfRuns> ways{{{{1.5F, 2.25F, 3, 7}, {4, 5, 6, 0}}, {}}, {{}, {{0.125F, 0, 1, 12}}}};
  write_times(folder / "times.json", ways);
  const auto read = read_times(folder / "times.json");
  ASSERT_EQ(read.size(), 2U);
  ASSERT_EQ(read[0].size(), 2U);
  ASSERT_EQ(read[0][0].size(), 2U);
  EXPECT_EQ(read[0][0][0].rendering, 2.25F);
  EXPECT_EQ(read[0][0][1].events, 0U);
  EXPECT_TRUE(read[0][1].empty());
  EXPECT_EQ(read[1][1][0].counting, 0.125F);
  for (const char* bad : {"", "{}", R"({"ways": [[[[1, 2, 3]]]]})", R"({"ways": [[[["a", 2, 3, 4]]]]})"}) {
    write_whole(folder / "bad.json", bad);
    EXPECT_THROW(read_times(folder / "bad.json"), Error) << bad;
  }
}

}  // namespace
}  // namespace tactile::trade
