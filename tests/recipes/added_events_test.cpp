#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "hand_made_events.hpp"

namespace tactile::recipes {
namespace {

using events::Event;
using test::event;

/// One event each 200 us for a second, as read-outs of a still scene.
std::vector<Event> still_second(std::int64_t begin_us = 0) {
  std::vector<Event> events;
  for (int i = 0; i <= 5000; ++i) events.push_back(event(begin_us + 200 * i));
  return events;
}

TEST(Noise, HasItsRateItsShareOfOnAndTheStampsOfTheReadouts) {
  const auto out = test::after_recipe("noise:100", still_second(), {100, 80});
  const double added = static_cast<double>(out.size()) - 5001;
  EXPECT_NEAR(added, 100'000, 2500);  // spread of the mean rate over 8000 pixels: below 1 %
  double on = 0;
  for (const Event& e : out) {
    on += e.on;
    ASSERT_EQ(us_of(e.t) % 200, 0);
  }
  EXPECT_NEAR((on - 5001) / added, measured_noise().on_share, 0.02);
}

TEST(Noise, OfAPoissonSensorScattersAsPoisson) {
  Recipe recipe = parse_recipe("noise:20");
  recipe.sensor = SensorNoise{};
  const auto out = worsened(still_second(), {&recipe, 1}, {50, 40});
  std::map<int, int> counts;
  for (const Event& e : out) ++counts[e.y * 50 + e.x];
  counts.erase(0);  // has the still events
  double sum = 0, squares = 0;
  for (int pixel = 1; pixel < 2000; ++pixel) {
    sum += counts[pixel];
    squares += counts[pixel] * counts[pixel];
  }
  const double mean = sum / 1999, variance = squares / 1999 - mean * mean;
  EXPECT_NEAR(mean, 10, 0.4);
  EXPECT_NEAR(variance / mean, 1, 0.15);
}

TEST(Noise, StopsInPausesAndKeepsItsOwnTimesBetweenRareEvents) {
  const auto out = test::after_recipe("noise:10", {event(0), event(900'000), event(3'000'000'000)}, {20, 20});
  for (const Event& e : out) EXPECT_TRUE(us_of(e.t) <= 900'000 || us_of(e.t) == 3'000'000'000) << us_of(e.t);
  std::set<std::int64_t> times;
  for (const Event& e : out) times.insert(us_of(e.t));
  EXPECT_GT(times.size(), 1000U);
}

TEST(HotPixels, AreAsManyAsTheSeverityAndKeepFewerOnesOfTheSameSeed) {
  const auto pixels_of = [](std::string_view recipe) {
    std::set<std::pair<int, int>> pixels;
    for (const Event& e : test::after_recipe(recipe, still_second(), {64, 48})) pixels.emplace(e.x, e.y);
    pixels.erase({0, 0});
    return pixels;
  };
  const auto few = pixels_of("hot-pixels:10"), many = pixels_of("hot-pixels:40");
  EXPECT_GE(few.size(), 9U);
  EXPECT_LE(few.size(), 10U);
  EXPECT_GE(many.size(), 38U);
  EXPECT_LE(many.size(), 40U);
  for (const auto& pixel : few) EXPECT_TRUE(many.contains(pixel));
}

TEST(HotPixels, FireAtTheirRateAndRegularlyIfTheirIntervalIsFixed) {
  Recipe recipe = parse_recipe("hot-pixels:1");
  recipe.sensor = SensorNoise{.hot_hz = {100}, .hot_on_shares = {1}, .hot_regularity = 1};
  std::vector<std::int64_t> times;
  for (const Event& e : worsened(still_second(), {&recipe, 1}, {1000, 1})) {
    if (e.x != 0) times.push_back(us_of(e.t));
  }
  EXPECT_NEAR(static_cast<double>(times.size()), 100, 1);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(static_cast<double>(times[i] - times[i - 1]), 10'000, 200);
}

TEST(Flicker, GivesOneOnAndOneOffEventPerPixelAndPeriodInTheirHalves) {
  for (const double hz : {100.0, 120.0}) {
    std::map<std::pair<int, int>, std::pair<int, int>> counts;
    const double period = 1e6 / hz;
    // Many events, so that added ones keep their times to a microsecond.
    std::vector<Event> dense;
    for (int us = 0; us < 100'000; ++us) dense.push_back(event(us, 0, 0));
    for (const Event& e : test::after_recipe(hz == 100 ? "flicker-100:20" : "flicker-120:20", dense, {30, 30})) {
      if (e.x == 0 && e.y == 0) continue;
      const double phase = std::fmod(static_cast<double>(us_of(e.t)), period) / period;
      EXPECT_GE(phase, (e.on != 0 ? 0.25 : 0.75) - 0.001);
      EXPECT_LE(phase, (e.on != 0 ? 0.5 : 1.0) + 0.001);
      ++(e.on != 0 ? counts[{e.x, e.y}].first : counts[{e.x, e.y}].second);
    }
    EXPECT_NEAR(static_cast<double>(counts.size()), 180, 50);
    for (const auto& [pixel, count] : counts) {
      EXPECT_EQ(count.first, static_cast<int>(hz / 10)) << hz;
      EXPECT_EQ(count.second, static_cast<int>(hz / 10)) << hz;
    }
  }
}

}  // namespace
}  // namespace tactile::recipes
