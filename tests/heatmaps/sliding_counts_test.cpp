#include "tactile/heatmaps/sliding_counts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "heatmaps/dense_reference.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

events::Event event_at(std::int64_t t_us, std::int16_t x = 0, std::int16_t y = 0) {
  return {.t = camera_time(t_us), .x = x, .y = y};
}

std::vector<std::uint32_t> all_of(const SlidingCounts& counts) {
  std::vector<std::uint32_t> all;
  for (int y = 0; y < counts.size().height; ++y) {
    for (int x = 0; x < counts.size().width; ++x) all.push_back(counts.at(x, y));
  }
  return all;
}

/// The counts that occur, how many pixels have any, and the largest.
void expect_histogram_of(const SlidingCounts& counts) {
  std::set<std::uint32_t> occur, listed;
  std::uint32_t active = 0;
  for (const std::uint32_t count : all_of(counts)) {
    active += count > 0 ? 1 : 0;
    if (count > 0) occur.insert(count);
  }
  counts.histogram().for_each_count([&](std::uint32_t count) {
    ASSERT_TRUE(listed.empty() || count > *listed.rbegin());
    listed.insert(count);
  });
  ASSERT_EQ(listed, occur);
  ASSERT_EQ(counts.histogram().active_pixels(), active);
  ASSERT_EQ(counts.histogram().largest(), occur.empty() ? 0 : *occur.rbegin());
}

TEST(SlidingCounts, KeepTheStartOfTheWindowAndLeaveItsEnd) {
  SlidingCounts counts({4, 3}, 10us);
  counts.add(std::vector{event_at(9, 0, 0), event_at(10, 1, 0), event_at(19, 2, 1), event_at(20, 3, 2)});
  counts.move_to(camera_time(20));
  EXPECT_EQ(counts.events(), 2U);
  EXPECT_EQ(counts.at(0, 0), 0U);
  EXPECT_EQ(counts.at(1, 0), 1U);
  EXPECT_EQ(counts.at(2, 1), 1U);
  EXPECT_EQ(counts.at(3, 2), 0U);
  counts.move_to(camera_time(30));
  EXPECT_EQ(counts.events(), 1U);
  EXPECT_EQ(counts.at(3, 2), 1U);
}

TEST(SlidingCounts, AreThoseOfEachWindowCountedAlone) {
  const events::SensorSize sensor{7, 5};
  Random random(1);
  std::vector<events::Event> events;
  for (std::int64_t t = -300; t < 300;) {
    events.push_back(event_at(t, static_cast<std::int16_t>(random.below(7)), static_cast<std::int16_t>(random.below(5))));
    t += static_cast<std::int64_t>(random.below(4));
  }
  for (const microseconds history : {1us, 2us, 30us, 400us}) {
    SlidingCounts counts(sensor, history);
    std::size_t given = 0;
    for (std::int64_t tick = -310; tick < 800; tick += static_cast<std::int64_t>(random.below(40))) {
      std::size_t end = given;
      while (end < events.size() && (events[end].t < camera_time(tick) || random.below(2) == 0)) ++end;  // some ahead of the tick
      counts.add(std::span(events).subspan(given, end - given));
      given = end;
      counts.move_to(camera_time(tick));
      const auto expected = test::dense_counts(events, sensor, camera_time(tick), history);
      ASSERT_EQ(all_of(counts), expected) << tick;
      expect_histogram_of(counts);
      std::uint64_t sum = 0;
      for (const std::uint32_t count : expected) sum += count;
      ASSERT_EQ(counts.events(), sum);
    }
  }
}

TEST(SlidingCounts, HoldAnyCount) {
  // Around the counts up to which one byte, two, and what is kept of small counts would do; up, down, and both in one step.
  const events::SensorSize sensor{3, 2};
  for (const std::int64_t most : {254, 255, 256, 257, 2'046, 2'047, 2'048, 2'049, 65'534, 65'535, 65'536, 65'537, 300'000}) {
    SlidingCounts counts(sensor, microseconds{most});
    std::vector<events::Event> events;
    for (std::int64_t t = 0; t < 2 * most; ++t) events.push_back(event_at(t, 1, 1));  // one every microsecond
    events.push_back(event_at(2 * most, 2, 0));
    counts.add(events);
    for (const std::int64_t tick : std::set<std::int64_t>{most - 2, most - 1, most, most + 1, 2 * most, 2 * most + 1,
                                                          3 * most - 2'048, 3 * most - 2'047, 3 * most - 1, 3 * most}) {
      counts.move_to(camera_time(tick));
      const std::int64_t last = std::min(tick, 2 * most), first = std::max<std::int64_t>(tick - most, 0);
      ASSERT_EQ(counts.at(1, 1), static_cast<std::uint32_t>(std::max<std::int64_t>(last - first, 0))) << most << " at " << tick;
      expect_histogram_of(counts);
    }
    counts.move_to(camera_time(4 * most));
    ASSERT_EQ(counts.events(), 0U);
    expect_histogram_of(counts);
  }
}

TEST(SlidingCounts, WorkAtBothEndsOfTheClock) {
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(), last = std::numeric_limits<std::int64_t>::max();
  SlidingCounts counts({2, 1}, 100us);
  counts.add(std::vector{event_at(first, 0), event_at(first + 5, 1)});
  counts.move_to(camera_time(first));
  EXPECT_EQ(counts.events(), 0U);
  counts.move_to(camera_time(first + 5));
  EXPECT_EQ(counts.events(), 1U);
  counts.move_to(camera_time(first + 100));
  EXPECT_EQ(counts.events(), 2U);
  counts.move_to(camera_time(first + 101));
  EXPECT_EQ(counts.events(), 1U);
  counts.add(std::vector{event_at(last - 1, 1), event_at(last, 0)});
  counts.move_to(camera_time(last));
  EXPECT_EQ(counts.events(), 1U);
  EXPECT_EQ(counts.at(1, 0), 1U);
}

TEST(SlidingCounts, RefuseEventsThatGoBackInTimeAndTakeNothingOfThem) {
  SlidingCounts counts({2, 2}, 10us);
  counts.add(std::vector{event_at(5)});
  EXPECT_THROW(counts.add(std::vector{event_at(6), event_at(5)}), Error);
  EXPECT_THROW(counts.add(std::vector{event_at(4)}), Error);
  counts.add(std::vector{event_at(5)});
  counts.move_to(camera_time(10));
  EXPECT_EQ(counts.events(), 2U);
}

TEST(SlidingCounts, RefuseEventsOutsideTheSensor) {
  SlidingCounts counts({4, 3}, 10us);
  for (const events::Event& event : {event_at(0, 4, 0), event_at(0, 0, 3), event_at(0, -1, 0), event_at(0, 0, -1)}) {
    EXPECT_THROW(counts.add(std::span(&event, 1)), Error);
  }
}

TEST(SlidingCounts, RefuseToMoveBack) {
  SlidingCounts counts({2, 2}, 10us);
  counts.move_to(camera_time(10));
  EXPECT_NO_THROW(counts.move_to(camera_time(10)));
  EXPECT_THROW(counts.move_to(camera_time(9)), Error);
}

TEST(SlidingCounts, RefuseASensorWithoutAreaOrOfAbsurdSizeAndAHistoryOfNothing) {
  EXPECT_THROW(SlidingCounts({0, 480}, 10us), Error);
  EXPECT_THROW(SlidingCounts({640, -1}, 10us), Error);
  EXPECT_THROW(SlidingCounts({32'769, 1}, 10us), Error);
  EXPECT_THROW(SlidingCounts({32767, 32767}, 10us), Error);
  EXPECT_THROW(SlidingCounts({640, 480}, 0us), Error);
}

}  // namespace
}  // namespace tactile::heatmaps
