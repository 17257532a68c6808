#include "tactile/heatmaps/sliding_counts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "heatmaps/dense_reference.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile {
namespace {

Event event_at(std::int64_t t_us, std::int16_t x = 0, std::int16_t y = 0) { return {.t = camera_time(t_us), .x = x, .y = y}; }

TEST(SlidingCounts, KeepTheBeginOfTheWindowAndLeaveItsEnd) {
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
  const SensorSize sensor{7, 5};
  Random random(1);
  std::vector<Event> events;
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
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), counts.counts().begin())) << tick;
      std::vector<std::uint32_t> active(counts.active().begin(), counts.active().end()), expected_active;
      for (std::uint32_t i = 0; i < expected.size(); ++i) {
        if (expected[i] > 0) expected_active.push_back(i);
      }
      std::sort(active.begin(), active.end());
      ASSERT_EQ(active, expected_active);
      std::uint64_t sum = 0;
      for (const std::uint32_t count : expected) sum += count;
      ASSERT_EQ(counts.events(), sum);
    }
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
  for (const Event& event : {event_at(0, 4, 0), event_at(0, 0, 3), event_at(0, -1, 0), event_at(0, 0, -1)}) {
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
  EXPECT_THROW(SlidingCounts({32767, 32767}, 10us), Error);
  EXPECT_THROW(SlidingCounts({640, 480}, 0us), Error);
}

}  // namespace
}  // namespace tactile
