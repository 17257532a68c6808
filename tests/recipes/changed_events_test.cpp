#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "hand_made_events.hpp"

namespace tactile::recipes {
namespace {

using events::Event;
using test::after_recipe;
using test::event;

using Events = std::vector<Event>;

TEST(Shift, MovesByWholePixelsAndLosesWhatLeaves) {
  const Events events{event(0, 1, 2), event(1, 14, 2), event(2, 13, 11)};
  EXPECT_EQ(after_recipe("shift:2", events), (Events{event(0, 3, 2), event(2, 15, 11)}));
  EXPECT_EQ(after_recipe("shift:-2", events), (Events{event(1, 12, 2), event(2, 11, 11)}));
  EXPECT_EQ(after_recipe("shift:2:direction_deg=90", events), (Events{event(0, 1, 4), event(1, 14, 4)}));
}

TEST(Rotate, TurnsClockwiseAroundTheMiddle) {
  const events::SensorSize square{5, 5};
  const Events events{event(0, 4, 2), event(1, 2, 0), event(2, 2, 2)};
  EXPECT_EQ(after_recipe("rotate:90", events, square), (Events{event(0, 2, 4), event(1, 4, 2), event(2, 2, 2)}));
  EXPECT_EQ(after_recipe("rotate:180", events, square), (Events{event(0, 0, 2), event(1, 2, 4), event(2, 2, 2)}));
  EXPECT_TRUE(after_recipe("rotate:90", {event(0, 15, 6)}).empty()) << "the corner of a wide picture leaves it";
}

TEST(Scale, KeepsTheEventsPerPixel) {
  Events all;  // 10 events at each of 16 x 12 pixels
  for (int i = 0; i < 16 * 12 * 10; ++i) all.push_back(event(i, i % 16, i / 16 % 12));
  const auto twice = after_recipe("scale:100", all);
  std::map<std::pair<int, int>, int> counts;
  for (const Event& e : twice) ++counts[{e.x, e.y}];
  EXPECT_EQ(counts.size(), 16U * 12U);
  EXPECT_NEAR(static_cast<double>(twice.size()), 1920, 150);
  counts.clear();
  const auto half = after_recipe("scale:-50", all);
  for (const Event& e : half) {
    ++counts[{e.x, e.y}];
    EXPECT_TRUE(e.x >= 4 && e.x <= 12 && e.y >= 3 && e.y <= 9);
  }
  EXPECT_NEAR(static_cast<double>(half.size()), 480, 80);
}

TEST(Mirror, ExchangesTheSides) {
  EXPECT_EQ(after_recipe("mirror-x", {event(0, 0, 3), event(1, 14, 4)}), (Events{event(0, 15, 3), event(1, 1, 4)}));
  EXPECT_EQ(after_recipe("mirror-y", {event(0, 0, 3), event(1, 14, 11)}), (Events{event(0, 0, 8), event(1, 14, 0)}));
}

TEST(Polarity, IsSwappedForItsShare) {
  EXPECT_EQ(after_recipe("polarity:100", {event(0, 1, 1, true), event(1, 1, 1, false)}),
            (Events{event(0, 1, 1, false), event(1, 1, 1, true)}));
  const auto events = test::random_events(10'000, {16, 12});
  const auto out = after_recipe("polarity:25", events);
  int swapped = 0;
  for (std::size_t i = 0; i < events.size(); ++i) swapped += events[i].on != out[i].on ? 1 : 0;
  EXPECT_NEAR(swapped, 2500, 200);
}

TEST(Threshold, DividesAPixelsChangesExactly) {
  Events rise;
  for (int i = 0; i < 12; ++i) rise.push_back(event(i, 5, 5));
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    EXPECT_EQ(after_recipe("threshold:100", rise, {16, 12}, seed).size(), 6U) << "twice as high: each second one";
    EXPECT_EQ(after_recipe("threshold:-50", rise, {16, 12}, seed).size(), 24U) << "half as high: each one twice";
    const auto between_these = after_recipe("threshold:60", rise, {16, 12}, seed).size();  // 12 / 1.6 = 7.5
    EXPECT_TRUE(between_these == 7 || between_these == 8) << between_these;
  }
}

TEST(Threshold, ThinsSingleEventsInTheMeanAndKeepsPixelsApart) {
  const auto events = test::random_events(30'000, {16, 12});
  EXPECT_NEAR(static_cast<double>(after_recipe("threshold:50", events).size()), 20'000, 500);
  EXPECT_NEAR(static_cast<double>(after_recipe("threshold:-20", events).size()), 37'500, 800);
}

TEST(Vibration, DisplacesByASine) {
  // At 50 Hz a quarter of a period is 5 ms: the displacements of these add up to 0 pairwise, and never exceed the amplitude.
  Events events;
  for (int i = 0; i < 400; ++i) events.push_back(event(100 * i, 50, 50));
  const auto out = after_recipe("vibration:8", events, {100, 100});
  ASSERT_EQ(out.size(), events.size());
  int least = 50, most = 50;
  double squares = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].y, 50);
    EXPECT_EQ(out[i].t, events[i].t);
    least = std::min<int>(least, out[i].x);
    most = std::max<int>(most, out[i].x);
    squares += (out[i].x - 50) * (out[i].x - 50);
    if (i + 100 >= out.size()) continue;
    EXPECT_NEAR(out[i].x + out[i + 100].x, 100, 1) << "half a period later it is on the other side";
  }
  EXPECT_EQ(least, 42);
  EXPECT_EQ(most, 58);
  EXPECT_NEAR(squares / 400, 32, 1) << "half of the amplitude's square";
}

TEST(Rounding, RoundsDownAlsoBelow0AndAtTheEnd) {
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(after_recipe("rounding:200", {event(-201), event(-200), event(-1), event(199), event(200)}),
            (Events{event(-400), event(-200), event(-200), event(0), event(200)}));
  EXPECT_EQ(after_recipe("rounding:1000", {event(first), event(first + 1)}), (Events{event(first), event(first)}));
}

TEST(Jitter, ScattersNormallyWithinThreeDeviationsAndKeepsAllEvents) {
  Events events;
  for (int i = 0; i < 10'000; ++i) events.push_back(event(10'000 * i, i % 16, i % 12));  // too far apart to change places
  const auto out = after_recipe("jitter:1000", events);
  ASSERT_EQ(out.size(), events.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].x, events[i].x);
    const auto moved = static_cast<double>(between(events[i].t, out[i].t).count());
    EXPECT_LE(std::abs(moved), 3000);
    sum += moved;
    squares += moved * moved;
  }
  EXPECT_NEAR(sum / 1e4, 0, 40);
  EXPECT_NEAR(std::sqrt(squares / 1e4), 993, 30);  // of a normal distribution cut at three deviations: 0.987 to 0.997
}

TEST(Late, GivesEventsOfLatePacketsTheTimeAtWhichTheyArrive) {
  const Events events{event(0, 1), event(9'999, 2), event(10'000, 3), event(25'000, 4), event(40'000, 5)};
  // Every packet is late: they end at 10, 20, 30 and 50 ms and arrive 7 ms later.
  EXPECT_EQ(after_recipe("late:7:share=100", events),
            (Events{event(17'000, 1), event(17'000, 2), event(27'000, 3), event(37'000, 4), event(57'000, 5)}));
  EXPECT_EQ(after_recipe("late:7:share=0", events), events);
}

TEST(Late, MakesItsShareOfThePacketsLate) {
  const auto events = test::random_events(40'000, {16, 12}, 100);  // 400 packets
  const auto out = after_recipe("late:20:share=30", events);
  EXPECT_EQ(out.size(), events.size());
  std::map<std::int64_t, int> counts;
  for (const Event& e : out) ++counts[us_of(e.t)];
  int late = 0;
  for (const auto& [t, count] : counts) late += count > 50 ? 1 : 0;
  EXPECT_NEAR(late, 120, 40);
}

}  // namespace
}  // namespace tactile::recipes
