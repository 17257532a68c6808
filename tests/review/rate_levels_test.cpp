#include "tactile/review/rate_levels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/random.hpp"

namespace tactile::review {
namespace {

constexpr std::int64_t begin_us = -123'457;

std::vector<events::Event> events_at(const std::vector<std::int64_t>& times) {
  std::vector<events::Event> events;
  for (const std::int64_t t : times) {
    events::Event event;
    event.t = camera_time(begin_us + t);
    events.push_back(event);
  }
  return events;
}

/// Random times in [0, length), the first of them 0, in bursts.
std::vector<std::int64_t> bursty_times(std::int64_t length, std::size_t count) {
  Random random(7);
  std::vector<std::int64_t> times{0};
  while (times.size() < count) {
    const auto burst = static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(length)));
    for (std::uint64_t i = random.below(40); i > 0; --i)
      times.push_back(std::min(length - 1, burst + static_cast<std::int64_t>(random.below(900))));
  }
  times.push_back(length - 1);
  return times;
}

RateLevels levels_of(const std::vector<std::int64_t>& times) {
  RateLevels levels(camera_time(begin_us), camera_time(begin_us + *std::max_element(times.begin(), times.end())));
  levels.add(events_at(times));
  levels.finish();
  return levels;
}

std::uint64_t count_in(const std::vector<std::int64_t>& times, std::int64_t from, std::int64_t to) {
  return static_cast<std::uint64_t>(
      std::count_if(times.begin(), times.end(), [&](std::int64_t t) { return from <= t && t < to; }));
}

TEST(RateLevels, SumsOfAnyBinsAreExactCounts) {
  const std::vector<std::int64_t> times = bursty_times(1'234'567, 20'000);
  const RateLevels levels = levels_of(times);
  ASSERT_EQ(levels.bin(), 100us);
  ASSERT_EQ(levels.bins(), 12'346U);
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const std::size_t a = random.below(levels.bins()), b = random.below(levels.bins());
    const std::size_t begin = std::min(a, b), end = std::max(a, b) + 1;
    const RateLevels::Sum sum = levels.over(begin, end);
    EXPECT_EQ(sum.events, count_in(times, 100 * static_cast<std::int64_t>(begin), 100 * static_cast<std::int64_t>(end)));
    std::uint32_t least = UINT32_MAX, most = 0;
    for (std::size_t bin = begin; bin < end; bin += 1 + (end - begin) / 50) {
      const auto count = static_cast<std::uint32_t>(
          count_in(times, 100 * static_cast<std::int64_t>(bin), 100 * static_cast<std::int64_t>(bin) + 100));
      least = std::min(least, count);
      most = std::max(most, count);
    }
    EXPECT_LE(sum.least, least);
    EXPECT_GE(sum.most, most);
  }
}

TEST(RateLevels, LeastAndMostAreThoseOfTheFinestBins) {
  // 3 events in the first 100 us, none in the next, 1, then 5.
  const RateLevels levels = levels_of({0, 10, 99, 200, 300, 301, 302, 303, 399});
  const RateLevels::Sum all = levels.over(0, 4), middle = levels.over(0, 3);
  EXPECT_EQ(all.events, 9U);
  EXPECT_EQ(all.least, 0U);
  EXPECT_EQ(all.most, 5U);
  EXPECT_EQ(middle.events, 4U);
  EXPECT_EQ(middle.most, 3U);
}

TEST(RateLevels, TheBucketsOfAWindowHoldEveryEventOnce) {
  const std::vector<std::int64_t> times = bursty_times(3'000'000, 30'000);
  const RateLevels levels = levels_of(times);
  for (const std::int64_t points : {1, 7, 100, 1200, 20'000}) {
    const SignalWindow window = levels.window({.from_us = 0, .to_us = 3'000'000, .points = points});
    ASSERT_FALSE(window.t_us.empty());
    EXPECT_LE(window.t_us.size(), static_cast<std::size_t>(points) + 1);
    EXPECT_EQ(window.bucket_us % 100, 0);
    double events = 0;
    for (std::size_t i = 0; i < window.t_us.size(); ++i) {
      const std::int64_t from = window.t_us[i] - window.bucket_us / 2;
      const std::int64_t to = std::min<std::int64_t>(from + window.bucket_us, 3'000'000);
      const double here = window.mean[i] * static_cast<double>(to - from) / 1000;
      EXPECT_NEAR(here, static_cast<double>(count_in(times, from, to)), 1e-6) << points << " points, bucket " << i;
      EXPECT_LE(window.least[i], window.mean[i] + 1e-9);
      EXPECT_GE(window.most[i], window.mean[i] - 1e-9);
      events += here;
    }
    EXPECT_NEAR(events, static_cast<double>(times.size()), 1e-3) << points << " points";
  }
}

TEST(RateLevels, BucketsStayWhereTheyAreWhenTheWindowMoves) {
  const RateLevels levels = levels_of(bursty_times(1'000'000, 5'000));
  const SignalWindow here = levels.window({.from_us = 100'000, .to_us = 500'000, .points = 100});
  const SignalWindow further = levels.window({.from_us = 101'300, .to_us = 501'300, .points = 100});
  const auto found = std::find(here.t_us.begin(), here.t_us.end(), further.t_us.at(5));
  ASSERT_NE(found, here.t_us.end());
  EXPECT_EQ(here.mean.at(static_cast<std::size_t>(found - here.t_us.begin())), further.mean.at(5));
}

TEST(RateLevels, AWindowOutsideTheRecordingIsEmpty) {
  const RateLevels levels = levels_of({0, 500});
  EXPECT_TRUE(levels.window({.from_us = 10'000, .to_us = 20'000, .points = 10}).t_us.empty());
  EXPECT_TRUE(levels.window({.from_us = -20'000, .to_us = -10'000, .points = 10}).t_us.empty());
  EXPECT_FALSE(levels.window({.from_us = -20'000, .to_us = 20'000, .points = 10}).t_us.empty());
}

TEST(RateLevels, ALongRecordingHasLongerBinsAndBoundedMemory) {
  const std::int64_t day = 24LL * 3600 * 1'000'000;
  RateLevels levels(camera_time(0), camera_time(day));
  EXPECT_LE(levels.bins(), RateLevels::most_bins);
  EXPECT_GT(2 * levels.bins(), RateLevels::most_bins);
  EXPECT_EQ(levels.bin().count() % 100, 0);
}

TEST(RateLevels, TheBusiestStretchIsThatOfASlidingWindow) {
  // 1 event each 100 us, and 30 more at 2.05 ms.
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 10'000; t += 100) times.push_back(t);
  for (int i = 0; i < 30; ++i) times.push_back(2'050);
  const RateLevels::Busiest busiest = levels_of(times).busiest(2ms);
  EXPECT_EQ(busiest.events, 50U);
  EXPECT_LE(busiest.begin, 20U);
  EXPECT_GT(busiest.begin + 20, 20U);
}

TEST(ExactRate, CountsEachEventInItsBucket) {
  const std::vector<CameraTime> times{camera_time(1000), camera_time(1009), camera_time(1010), camera_time(1029),
                                      camera_time(1030)};
  // From 0 to 30 us after the first event, in three buckets of 10 us: 2, 1 and 1 events.
  const SignalWindow window = exact_rate(times, camera_time(1000), {.from_us = 0, .to_us = 30, .points = 3});
  ASSERT_EQ(window.t_us, (std::vector<std::int64_t>{5, 15, 25}));
  EXPECT_DOUBLE_EQ(window.mean[0], 200);  // 2 events in 0.01 ms
  EXPECT_DOUBLE_EQ(window.mean[1], 100);
  EXPECT_DOUBLE_EQ(window.mean[2], 100);
  EXPECT_EQ(window.least, window.most);
}

}  // namespace
}  // namespace tactile::review
