#include "tactile/review/rate_counts.hpp"

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

RateCounts counts_of(const std::vector<std::int64_t>& times) {
  RateCounts counts(camera_time(begin_us), camera_time(begin_us + *std::max_element(times.begin(), times.end())));
  counts.add(events_at(times));
  counts.finish();
  return counts;
}

std::uint64_t count_in(const std::vector<std::int64_t>& times, std::int64_t from, std::int64_t to) {
  return static_cast<std::uint64_t>(
      std::count_if(times.begin(), times.end(), [&](std::int64_t t) { return from <= t && t < to; }));
}

TEST(RateCounts, SumsOfAnyBinsAreExactCounts) {
  const std::vector<std::int64_t> times = bursty_times(1'234'567, 20'000);
  const RateCounts counts = counts_of(times);
  ASSERT_EQ(counts.bin(), 100us);
  ASSERT_EQ(counts.bins(), 12'346U);
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const std::size_t a = random.below(counts.bins()), b = random.below(counts.bins());
    const std::size_t begin = std::min(a, b), end = std::max(a, b) + 1;
    EXPECT_EQ(counts.events_in(begin, end),
              count_in(times, 100 * static_cast<std::int64_t>(begin), 100 * static_cast<std::int64_t>(end)));
  }
}

TEST(RateCounts, ASmoothRateIsTheMeanAroundEachTime) {
  // 3 events in the first 100 us, none in the next, 1, then 5.
  const RateCounts counts = counts_of({0, 10, 99, 200, 300, 301, 302, 303, 399});
  const SignalWindow window = counts.window({.from_us = 0, .to_us = 400, .points = 4, .smooth_us = 300});
  ASSERT_EQ(window.t_us, (std::vector<std::int64_t>{50, 150, 250, 350}));
  EXPECT_EQ(window.over_us, 300);
  EXPECT_DOUBLE_EQ(window.mean[0], 3 / 0.2) << "of the two bins that there are";
  EXPECT_DOUBLE_EQ(window.mean[1], 4 / 0.3);
  EXPECT_DOUBLE_EQ(window.mean[2], 6 / 0.3);
  EXPECT_DOUBLE_EQ(window.mean[3], 6 / 0.2);
}

TEST(RateCounts, SmoothingLeavesTheNoiseOfCountsBelowARise) {
  // 40 events per ms at random, 80 from 500 ms on. The page shows 60 ms by 1000 pixels.
  Random random(5);
  std::vector<std::int64_t> times{0};
  for (int i = 0; i < 40'000; ++i) times.push_back(static_cast<std::int64_t>(random.below(1'000'000)));
  for (int i = 0; i < 20'000; ++i) times.push_back(500'000 + static_cast<std::int64_t>(random.below(500'000)));
  times.push_back(999'999);
  const RateCounts counts = counts_of(times);
  const auto largest_before = [&](std::int64_t smooth) {
    const SignalWindow window = counts.window({.from_us = 440'000, .to_us = 499'000, .points = 1000, .smooth_us = smooth});
    return *std::max_element(window.mean.begin(), window.mean.end());
  };
  EXPECT_GT(largest_before(0), 80) << "single bins hide the rise";
  EXPECT_LT(largest_before(2'000), 60);
}

TEST(RateCounts, TheBucketsOfAWindowHoldEveryEventOnce) {
  const std::vector<std::int64_t> times = bursty_times(3'000'000, 30'000);
  const RateCounts counts = counts_of(times);
  for (const std::int64_t points : {1, 7, 100, 1200, 20'000}) {
    const SignalWindow window = counts.window({.from_us = 0, .to_us = 3'000'000, .points = points});
    ASSERT_FALSE(window.t_us.empty());
    EXPECT_LE(window.t_us.size(), static_cast<std::size_t>(points) + 1);
    EXPECT_EQ(window.bucket_us % 100, 0);
    double events = 0;
    for (std::size_t i = 0; i < window.t_us.size(); ++i) {
      const std::int64_t from = window.t_us[i] - window.bucket_us / 2;
      const std::int64_t to = std::min<std::int64_t>(from + window.bucket_us, 3'000'000);
      const double here = window.mean[i] * static_cast<double>(to - from) / 1000;
      EXPECT_NEAR(here, static_cast<double>(count_in(times, from, to)), 1e-6) << points << " points, bucket " << i;
      events += here;
    }
    EXPECT_NEAR(events, static_cast<double>(times.size()), 1e-3) << points << " points";
  }
}

TEST(RateCounts, BucketsStayWhereTheyAreWhenTheWindowMoves) {
  const RateCounts counts = counts_of(bursty_times(1'000'000, 5'000));
  const SignalWindow here = counts.window({.from_us = 100'000, .to_us = 500'000, .points = 100});
  const SignalWindow further = counts.window({.from_us = 101'300, .to_us = 501'300, .points = 100});
  const auto found = std::find(here.t_us.begin(), here.t_us.end(), further.t_us.at(5));
  ASSERT_NE(found, here.t_us.end());
  EXPECT_EQ(here.mean.at(static_cast<std::size_t>(found - here.t_us.begin())), further.mean.at(5));
}

TEST(RateCounts, AWindowOutsideTheRecordingIsEmpty) {
  const RateCounts counts = counts_of({0, 500});
  EXPECT_TRUE(counts.window({.from_us = 10'000, .to_us = 20'000, .points = 10}).t_us.empty());
  EXPECT_TRUE(counts.window({.from_us = -20'000, .to_us = -10'000, .points = 10}).t_us.empty());
  EXPECT_FALSE(counts.window({.from_us = -20'000, .to_us = 20'000, .points = 10}).t_us.empty());
}

TEST(RateCounts, ALongRecordingHasLongerBinsAndBoundedMemory) {
  const std::int64_t day = 24LL * 3600 * 1'000'000;
  RateCounts counts(camera_time(0), camera_time(day));
  EXPECT_LE(counts.bins(), RateCounts::most_bins);
  EXPECT_GT(2 * counts.bins(), RateCounts::most_bins);
  EXPECT_EQ(counts.bin().count() % 100, 0);
}

TEST(RateCounts, TheBusiestStretchIsThatOfASlidingWindow) {
  // 1 event each 100 us, and 30 more at 2.05 ms.
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t < 10'000; t += 100) times.push_back(t);
  for (int i = 0; i < 30; ++i) times.push_back(2'050);
  const RateCounts::Busiest busiest = counts_of(times).busiest(2ms);
  EXPECT_EQ(busiest.events, 50U);
  EXPECT_LE(busiest.begin, 20U);
  EXPECT_GT(busiest.begin + 20, 20U);
}

}  // namespace
}  // namespace tactile::review
