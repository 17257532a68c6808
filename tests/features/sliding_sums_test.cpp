#include "tactile/features/sliding_sums.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::features {
namespace {

constexpr events::SensorSize summed_sensor{640, 480};

events::Event event_at(std::int64_t us, int x, int y, bool on) {
  return {camera_time(us), static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::uint8_t>(on ? 1 : 0)};
}

/// The sums of events in [begin, end), computed afresh by the definition.
EventSums slow_sums(const std::vector<events::Event>& events, std::int64_t begin_us, std::int64_t end_us) {
  EventSums sums;
  for (const events::Event& event : events) {
    if (us_of(event.t) < begin_us || us_of(event.t) >= end_us) continue;
    EventSums::OfPolarity& of = sums.of[event.on];
    const auto x = static_cast<std::uint64_t>(event.x), y = static_cast<std::uint64_t>(event.y);
    of.events += 1, of.x += x, of.y += y, of.xx += x * x, of.yy += y * y, of.xy += x * y;
    sums.cells[event.on][y * 18 / 480 * 24 + x * 24 / 640] += 1;
  }
  return sums;
}

std::vector<events::Event> any_events(std::int64_t from_us, std::size_t count, Random& random) {
  std::vector<events::Event> events;
  std::int64_t t = from_us;
  for (std::size_t i = 0; i < count; ++i) {
    t += static_cast<std::int64_t>(random.below(8) == 0 ? random.below(3000) : random.below(20));
    events.push_back(event_at(t, static_cast<int>(random.below(640)), static_cast<int>(random.below(480)), random.below(2) == 1));
  }
  return events;
}

TEST(SlidingSums, EqualASlowSumInEveryBinAtEveryTickAndAfterSkippedOnes) {
  Random random(7);
  const auto events = any_events(-20'000, 20'000, random);
  SlidingSums sums(summed_sensor, 20ms, 1ms);
  std::size_t given = 0;
  for (std::int64_t t = 0; t < us_of(events.back().t);
       t += random.below(5) == 0 ? 2'000 * static_cast<int>(random.below(30)) : 2'000) {
    // Up to 5 ms ahead of the tick, as packets come.
    std::size_t end = given;
    while (end < events.size() && us_of(events[end].t) < t + 5'000) ++end;
    sums.add(std::span(events).subspan(given, end - given));
    given = end;
    sums.move_to(camera_time(t));
    std::uint64_t count = 0;
    for (std::size_t k = 0; k < 20; ++k) {
      const std::int64_t begin = t - 20'000 + static_cast<std::int64_t>(k) * 1'000;
      ASSERT_EQ(sums.bin(k), slow_sums(events, begin, begin + 1'000)) << "at " << t << ", bin " << k;
      count += sums.bin(k).of[0].events + sums.bin(k).of[1].events;
    }
    EXPECT_EQ(sums.events(), count);
  }
}

TEST(SlidingSums, CountEventsThatComeAfterTheHistoryHasMovedAhead) {
  SlidingSums sums(summed_sensor, 4ms, 2ms);
  sums.move_to(camera_time(10'000));
  sums.add(std::vector{event_at(5'999, 1, 1, true), event_at(6'000, 2, 2, true), event_at(9'999, 3, 3, true)});
  sums.move_to(camera_time(10'000));
  EXPECT_EQ(sums.events(), 2U);
  EXPECT_EQ(sums.bin(0).of[1].x, 2U);
  EXPECT_EQ(sums.bin(1).of[1].x, 3U);
}

TEST(SlidingSums, DoNotDriftInAYear) {
  // One tick in each minute of a year, at both ends of camera time's sign: sums stay those of their own events.
  Random random(3);
  constexpr std::int64_t year_us = 365LL * 24 * 3600 * 1'000'000, minute_us = 60'000'000;
  SlidingSums sums(summed_sensor, 4ms, 2ms);
  std::vector<events::Event> last;
  for (std::int64_t t = -year_us / 2; t < year_us / 2; t += minute_us) {
    last = any_events(t - 4'500, 12, random);
    std::erase_if(last, [t](const events::Event& event) { return us_of(event.t) >= t; });
    sums.add(last);
    sums.move_to(camera_time(t));
    for (std::size_t k = 0; k < 2; ++k) {
      const std::int64_t begin = t - 4'000 + static_cast<std::int64_t>(k) * 2'000;
      ASSERT_EQ(sums.bin(k), slow_sums(last, begin, begin + 2'000));
    }
  }
}

TEST(SlidingSums, LeaveOutTheEventsOfMaskedPixels) {
  SlidingSums sums(summed_sensor, 2ms, 2ms, {{5, 6}});
  sums.add(std::vector{event_at(0, 5, 6, true), event_at(1, 6, 5, false)});
  sums.move_to(camera_time(2'000));
  EXPECT_EQ(sums.events(), 1U);
  EXPECT_EQ(sums.bin(0).of[0].x, 6U);
}

TEST(SlidingSums, RefuseWhatTheyCannotCount) {
  EXPECT_THROW(SlidingSums({0, 480}, 4ms, 2ms), Error);
  EXPECT_THROW(SlidingSums(summed_sensor, 5ms, 2ms), Error);
  EXPECT_THROW(SlidingSums(summed_sensor, 5ms, 1us), Error);
  SlidingSums sums(summed_sensor, 4ms, 2ms);
  EXPECT_THROW(sums.add(std::vector{event_at(0, 640, 0, true)}), Error);
  EXPECT_THROW(sums.add(std::vector{event_at(0, 0, -1, true)}), Error);
  sums.add(std::vector{event_at(5, 0, 0, true)});
  EXPECT_THROW(sums.add(std::vector{event_at(4, 0, 0, true)}), Error);
  sums.move_to(camera_time(2'000));
  EXPECT_EQ(sums.events(), 1U);
  EXPECT_THROW(sums.move_to(camera_time(0)), Error);
  EXPECT_THROW(sums.move_to(camera_time(2'001)), Error);
}

}  // namespace
}  // namespace tactile::features
