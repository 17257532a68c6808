// Random windows that slide along random events, compared with the plain formula for each window.

#include <gtest/gtest.h>

#include <limits>

#include "heatmaps/rendered_heatmap.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

template <class T>
T any_of(Random& random, std::initializer_list<T> values) {
  return *(values.begin() + random.below(values.size()));
}

/// Events over about `length_us` from `begin_us` on, many of them at whole ticks, some at pixels hotter than others.
std::vector<events::Event> any_events(Random& random, events::SensorSize sensor, std::int64_t begin_us, std::int64_t length_us,
                                      std::int64_t tick_us) {
  const std::size_t count = any_of<std::size_t>(random, {0, 1, 30, 400, 3'000});
  const double share_of_hot = random.uniform(0, 0.7), share_on_ticks = random.uniform();
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < count; ++i) {
    std::int64_t t = static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(length_us)));
    if (random.uniform() < share_on_ticks) t -= t % tick_us;
    times.push_back(begin_us + t);
  }
  std::sort(times.begin(), times.end());
  std::vector<events::Event> events;
  const auto hot_x = static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(sensor.width)));
  for (const std::int64_t t : times) {
    const bool is_hot = random.uniform() < share_of_hot;
    events.push_back({.t = camera_time(t),
                      .x = is_hot ? hot_x : static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(sensor.width))),
                      .y = static_cast<std::int16_t>(is_hot ? 0 : random.below(static_cast<std::uint64_t>(sensor.height))),
                      .on = static_cast<std::uint8_t>(random.below(2))});
  }
  return events;
}

class HeatmapProperties : public testing::TestWithParam<std::uint64_t> {};

TEST_P(HeatmapProperties, EachWindowIsRenderedAsIfItWereAlone) {
  Random random(GetParam());
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(), last = std::numeric_limits<std::int64_t>::max();
  for (int round = 0; round < 25; ++round) {
    HeatmapOptions options;
    options.tick = microseconds{any_of<std::int64_t>(random, {1, 500, 2'000, 7'000})};
    options.history = options.tick * any_of<std::int64_t>(random, {1, 2, 20, 500});
    options.denoise = any_of(random, {Denoise::mean, Denoise::literal, Denoise::none});
    options.resize = any_of(random, {Resize::area, Resize::linear});
    options.factor = any_of(random, {0.1, 0.2, 0.25, 0.5, 1.0, 1.0 / 17});
    const events::SensorSize sensor{static_cast<int>(9 + random.below(80)), static_cast<int>(9 + random.below(60))};
    const std::int64_t tick_us = options.tick.count(), length_us = 3 * options.history.count() + 10 * tick_us;
    const std::int64_t begin_us = any_of<std::int64_t>(
        random, {0, -length_us / 2, 1'700'000'000'000'000, first, first + 3, last - length_us, last - length_us / 2 * 2});
    const std::vector<events::Event> events = any_events(random, sensor, begin_us, length_us, tick_us);

    HeatmapRenderer renderer(sensor, options);
    std::size_t given = 0;
    CameraTime tick = camera_time(begin_us);
    for (int step = 0; step < 12; ++step) {
      std::size_t end = given;
      while (end < events.size() && (events[end].t < tick || random.below(4) > 0)) ++end;  // some ahead of the tick
      renderer.add(std::span(events).subspan(given, end - given));
      given = end;
      renderer.move_to(tick);
      ASSERT_TRUE(test::is_true(renderer, test::dense_counts(events, sensor, tick, options.history), sensor))
          << round << ' ' << step;

      HeatmapRenderer fresh(sensor, options);  // to the last bit, however the counts came about
      fresh.add(std::span(events).first(given));
      fresh.move_to(tick);
      ASSERT_EQ(test::rendered<float>(renderer), test::rendered<float>(fresh));
      ASSERT_EQ(test::rendered<std::uint8_t>(renderer), test::rendered<std::uint8_t>(fresh));
      tick = after(tick, options.tick * static_cast<std::int64_t>(random.below(3) == 0 ? random.below(200) : random.below(4)));
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, HeatmapProperties, testing::Range<std::uint64_t>(1, 9));

TEST(HeatmapProperties, CountsFromOneToAMillionAreWeighedRight) {
  Random random(5);
  for (int round = 0; round < 12; ++round) {
    const events::SensorSize sensor{static_cast<int>(5 + random.below(20)), static_cast<int>(5 + random.below(20))};
    const double largest = std::pow(10.0, random.uniform(0, 6));
    std::vector<test::Hits> pixels;
    for (std::uint64_t i = 0; i < 1 + random.below(12); ++i) {
      pixels.push_back({static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.width))),
                        static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.height))),
                        1 + static_cast<std::uint32_t>(random.below(static_cast<std::uint64_t>(largest)))});
    }
    for (const HeatmapOptions& options : test::every_method()) ASSERT_TRUE(test::is_true(pixels, sensor, options)) << round;
  }
}

TEST(HeatmapProperties, EventsOutOfOrderOrOutsideAreRefusedAndLeaveTheHeatmapAsItWas) {
  HeatmapRenderer renderer({20, 10}, {});
  renderer.add(std::vector{events::Event{.t = camera_time(1'000), .x = 3, .y = 3},
                           events::Event{.t = camera_time(2'000), .x = 8, .y = 3}});
  renderer.move_to(camera_time(2'001));
  const auto before = test::rendered<std::uint8_t>(renderer);
  EXPECT_THROW(renderer.add(std::vector{events::Event{.t = camera_time(3'000)}, events::Event{.t = camera_time(2'999)}}), Error);
  EXPECT_THROW(renderer.add(std::vector{events::Event{.t = camera_time(1'999)}}), Error);
  EXPECT_THROW(renderer.add(std::vector{events::Event{.t = camera_time(3'000)}, events::Event{.t = camera_time(3'000), .x = 20}}),
               Error);
  EXPECT_THROW(renderer.move_to(camera_time(2'000)), Error);
  renderer.move_to(camera_time(2'002));
  EXPECT_EQ(renderer.events(), 2U);
  EXPECT_EQ(test::rendered<std::uint8_t>(renderer), before);
}

}  // namespace
}  // namespace tactile::heatmaps
