#include "tactile/detect/tick_clock.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/host_time.hpp"

namespace tactile::detect {
namespace {

using test::host_time;

constexpr std::int64_t host_begin_us = 1'700'000'000'000'000;
constexpr TickClockOptions usual{.tick = 2ms, .history = 40ms, .slack = 2ms};

TEST(TickClock, BeginsOnceTheHistoryLiesWithinTheStream) {
  TickClock clock(usual);
  clock.arrived(camera_time(1), camera_time(41'999), host_time(host_begin_us));
  EXPECT_FALSE(clock.next(host_time(host_begin_us)));
  clock.arrived(camera_time(41'999), camera_time(42'000), host_time(host_begin_us + 10));
  const auto tick = clock.next(host_time(host_begin_us + 10));
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->t, camera_time(42'000)) << "an event at the tick closes it";
  EXPECT_TRUE(tick->by_events);
  EXPECT_EQ(tick->closed, host_time(host_begin_us + 10));
  clock.reported(*tick);
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 10)));
}

TEST(TickClock, ClosesBySlackInSilenceAndNotBefore) {
  TickClock clock(usual);
  clock.arrived(camera_time(0), camera_time(1'000), host_time(host_begin_us + 1'000));
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 41'999)));
  const auto tick = clock.next(host_time(host_begin_us + 42'003));  // 3 us for what the clocks may have drifted apart in 39 ms
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->t, camera_time(40'000));
  EXPECT_FALSE(tick->by_events);
  EXPECT_EQ(clock.next_by_host(), tick->closed);
  clock.reported(*tick);
  ASSERT_TRUE(clock.next_by_host());
  EXPECT_NEAR(static_cast<double>((*clock.next_by_host() - tick->closed).count()), 2'000, 1);
}

TEST(TickClock, WaitsAsLongAsTheLongestPacketIs) {
  TickClock clock(usual);
  clock.arrived(camera_time(0), camera_time(10'000), host_time(host_begin_us + 10'000));
  EXPECT_EQ(clock.longest_packet(), 10ms);
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 49'999)));
  EXPECT_TRUE(clock.next(host_time(host_begin_us + 50'010)));
}

TEST(TickClock, ClosesByEventsAloneIfRequested) {
  TickClock clock({.tick = 2ms, .history = 40ms, .slack = 2ms, .by_events_alone = true});
  clock.arrived(camera_time(0), camera_time(1'000), host_time(host_begin_us));
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 3'600'000'000)));
  EXPECT_FALSE(clock.next_by_host());
}

TEST(TickClock, SkipsToTheNewestAndReportsHowManyItLeftOut) {
  TickClock clock(usual);
  clock.arrived(camera_time(0), camera_time(1'000), host_time(host_begin_us + 1'000));
  clock.arrived(camera_time(1'000), camera_time(51'000), host_time(host_begin_us + 51'000));
  const auto newest = clock.newest(host_time(host_begin_us + 51'000));
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->t, camera_time(50'000));
  EXPECT_EQ(newest->skipped, 5U);
  clock.reported(*newest);
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 51'000)));
  EXPECT_EQ(clock.last_reported(), camera_time(50'000));
}

TEST(TickClock, KnowsWhichEventsAreTooLate) {
  TickClock clock(usual);
  clock.arrived(camera_time(0), camera_time(42'500), host_time(host_begin_us));
  clock.reported(*clock.newest(host_time(host_begin_us)));
  std::vector<events::Event> events(3);
  events[0].t = camera_time(41'990);
  events[1].t = camera_time(41'999);
  events[2].t = camera_time(42'000);
  EXPECT_EQ(clock.too_late(events), 2U) << "one at the tick itself belongs to the next";
}

TEST(TickClock, AnswersEachEventsTickByTheHostAYearLong) {
  TickClock clock(usual);
  constexpr std::int64_t day = 86'400'000'000;
  for (std::int64_t i = 0; i <= 365; ++i) {
    const std::int64_t t = i * day + 777;
    clock.arrived(camera_time(t), camera_time(t + 500), host_time(host_begin_us + t + 700));
    const auto tick = clock.newest(host_time(host_begin_us + t + 700));
    if (i == 0) continue;
    ASSERT_TRUE(tick) << i;
    EXPECT_EQ(us_of(tick->t) % 2'000, 0);
    EXPECT_EQ(tick->t, camera_time(i * day));
    if (i > 1) {
      EXPECT_EQ(tick->skipped + 1, static_cast<std::uint64_t>(day / 2'000));
    }
    clock.reported(*tick);
  }
  // And silence continues: the newest tick by the host is some seconds too old after a day, never too new.
  const auto later = clock.newest(host_time(host_begin_us + 366 * day));
  ASSERT_TRUE(later);
  EXPECT_LE(later->t, camera_time(366 * day));
  EXPECT_GE(later->t, camera_time(366 * day - 30'000'000));
  EXPECT_LE(later->closed, host_time(host_begin_us + 366 * day));
}

TEST(TickClock, EndsWhereTheClockEnds) {
  constexpr std::int64_t highest = std::numeric_limits<std::int64_t>::max();
  TickClock clock({.tick = 2ms, .history = 4ms, .slack = 2ms, .by_events_alone = true});
  clock.arrived(camera_time(highest - 10'000), camera_time(highest), host_time(host_begin_us));
  std::vector<CameraTime> ticks;
  while (const auto tick = clock.next(host_time(host_begin_us))) {
    ticks.push_back(tick->t);
    clock.reported(*tick);
    ASSERT_LE(ticks.size(), 5U);
  }
  const std::int64_t last = highest - highest % 2'000;
  EXPECT_EQ(ticks, (std::vector<CameraTime>{camera_time(last - 4'000), camera_time(last - 2'000), camera_time(last)}));
}

TEST(TickClock, HasNoTickWhereNoHistoryFits) {
  constexpr std::int64_t highest = std::numeric_limits<std::int64_t>::max();
  TickClock clock(usual);
  clock.arrived(camera_time(highest - 10), camera_time(highest), host_time(host_begin_us));
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 1'000'000)));
  EXPECT_FALSE(clock.newest(host_time(host_begin_us + 1'000'000)));
  EXPECT_FALSE(clock.next_by_host());
}

TEST(TickClock, BeginsAtTheLowestTimeThereIs) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min();
  TickClock clock({.tick = 2ms, .history = 4ms, .slack = 2ms, .by_events_alone = true});
  clock.arrived(camera_time(lowest), camera_time(lowest + 7'000), host_time(host_begin_us));
  const auto tick = clock.next(host_time(host_begin_us));
  ASSERT_TRUE(tick);
  EXPECT_EQ(us_of(tick->t) % 2'000, 0);
  EXPECT_GE(us_of(tick->t), lowest + 4'000);
  EXPECT_LT(us_of(tick->t), lowest + 6'000);
}

TEST(TickClock, ForgetsAStreamThatBeganAgain) {
  TickClock clock(usual);
  clock.arrived(camera_time(9'000'000), camera_time(9'060'000), host_time(host_begin_us));
  clock.reported(*clock.newest(host_time(host_begin_us)));
  clock.restart();
  EXPECT_FALSE(clock.next(host_time(host_begin_us + 1'000'000)));
  std::vector<events::Event> earlier(1);
  EXPECT_EQ(clock.too_late(earlier), 0U);
  clock.arrived(camera_time(100), camera_time(42'000), host_time(host_begin_us + 1));
  ASSERT_TRUE(clock.next(host_time(host_begin_us + 1)));
  EXPECT_EQ(clock.next(host_time(host_begin_us + 1))->t, camera_time(42'000));
}

TEST(TickClock, ContinuesAcrossTheEndsOf31And32Bits) {
  for (const std::int64_t end : {std::int64_t{1} << 31, std::int64_t{1} << 32}) {
    TickClock clock(usual);
    std::vector<CameraTime> reported;
    for (std::int64_t t = end - 60'000; t <= end + 20'000; t += 500) {
      clock.arrived(camera_time(t), camera_time(t), host_time(host_begin_us + t));
      while (const auto tick = clock.next(host_time(host_begin_us + t))) {
        reported.push_back(tick->t);
        EXPECT_TRUE(tick->by_events);
        clock.reported(*tick);
      }
    }
    ASSERT_GT(reported.size(), 15U);
    EXPECT_LT(reported.front(), camera_time(end));
    EXPECT_GT(reported.back(), camera_time(end));
    for (std::size_t i = 1; i < reported.size(); ++i) EXPECT_EQ(reported[i] - reported[i - 1], 2ms);
  }
}

}  // namespace
}  // namespace tactile::detect
