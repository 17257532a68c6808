#include "tactile/core/ticks.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tactile {
namespace {

constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min(), latest = std::numeric_limits<std::int64_t>::max();

TEST(Ticks, AreWholeMultiplesOnBothSidesOfZero) {
  EXPECT_EQ(first_tick_from(camera_time(4'000), 2ms), camera_time(4'000));
  EXPECT_EQ(first_tick_from(camera_time(4'001), 2ms), camera_time(6'000));
  EXPECT_EQ(first_tick_from(camera_time(-4'001), 2ms), camera_time(-4'000));
  EXPECT_EQ(first_tick_from(camera_time(-1), 2ms), camera_time(0));
  EXPECT_EQ(last_tick_until(camera_time(4'000), 2ms), camera_time(4'000));
  EXPECT_EQ(last_tick_until(camera_time(3'999), 2ms), camera_time(2'000));
  EXPECT_EQ(last_tick_until(camera_time(-1), 2ms), camera_time(-2'000));
  EXPECT_EQ(last_tick_until(camera_time(-2'000), 2ms), camera_time(-2'000));
}

TEST(FullTicks, BeginWithTheFirstWholeHistoryAndEndWithTheLastEvent) {
  const TickRange range = full_ticks(camera_time(1), camera_time(20'000), 10ms, 2ms);
  EXPECT_EQ(range.first, camera_time(12'000));
  EXPECT_EQ(range.count, 5);
  EXPECT_EQ(range.at(4), camera_time(20'000));
  EXPECT_EQ(full_ticks(camera_time(0), camera_time(10'000), 10ms, 2ms).count, 1);
  EXPECT_EQ(full_ticks(camera_time(0), camera_time(9'999), 10ms, 2ms).count, 0);
  EXPECT_EQ(full_ticks(camera_time(1), camera_time(11'999), 10ms, 2ms).count, 0);
}

TEST(FullTicks, HoldAtTheEndsOfTheClock) {
  const TickRange low = full_ticks(camera_time(earliest), camera_time(earliest + 10'000), 4ms, 2ms);
  ASSERT_GT(low.count, 0);
  EXPECT_GE(us_of(low.first), earliest + 4'000);
  EXPECT_EQ(us_of(low.first) % 2'000, 0);
  EXPECT_EQ(full_ticks(camera_time(latest - 3'000), camera_time(latest), 4ms, 2ms).count, 0);
  EXPECT_EQ(full_ticks(camera_time(latest), camera_time(latest), 1us, 2ms).count, 0);
  EXPECT_EQ(full_ticks(camera_time(earliest), camera_time(earliest), 0us, 2ms).count, 0);
  const TickRange high = full_ticks(camera_time(latest - 10'000), camera_time(latest), 4ms, 2ms);
  ASSERT_GT(high.count, 0);
  EXPECT_LE(high.at(high.count - 1), camera_time(latest));
}

TEST(FullTicks, ReachFromOneEndOfTheClockToTheOther) {
  const TickRange all = full_ticks(camera_time(earliest), camera_time(latest), 2ms, 2ms);
  const std::int64_t last = latest - latest % 2'000;
  EXPECT_EQ(all.at(0), all.first);
  EXPECT_EQ(us_of(all.at(1)), us_of(all.first) + 2'000);
  EXPECT_EQ(us_of(all.at(all.count - 1)), last);
  EXPECT_EQ(us_of(all.at(all.count - 2)), last - 2'000);
  EXPECT_EQ(all.at(all.count), camera_time(latest)) << "held at the end of the clock";
  std::int64_t middle = 0;  // by halves: where is 0?
  for (std::int64_t step = std::int64_t{1} << 53; step > 0; step /= 2) {
    if (middle + step < all.count && all.at(middle + step) <= camera_time(0)) middle += step;
  }
  EXPECT_EQ(us_of(all.at(middle)), 0);
}

TEST(FullTicks, OfAYearAreCountedExactlyAndTooManyForOneRun) {
  constexpr std::int64_t year = 365 * std::int64_t{86'400'000'000};
  const TickRange ticks = full_ticks(camera_time(777), camera_time(777 + year), 40ms, 2ms);
  EXPECT_EQ(ticks.count, year / 2'000 - 20);
  EXPECT_EQ(us_of(ticks.at(ticks.count - 1)), year);
  EXPECT_NE(why_too_many(ticks).find("15767999980 ticks of 2000 us"), std::string::npos) << why_too_many(ticks);
  EXPECT_EQ(why_too_many(full_ticks(camera_time(0), camera_time(most_ticks * 2'000), 2ms, 2ms)), "");
  EXPECT_NE(why_too_many(full_ticks(camera_time(0), camera_time((most_ticks + 1) * 2'000), 2ms, 2ms)), "");
}

}  // namespace
}  // namespace tactile
