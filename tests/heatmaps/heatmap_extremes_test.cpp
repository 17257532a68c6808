// Unlikely inputs for which a heatmap must be correct, compared with equations 2 to 5 in long double.

#include <gtest/gtest.h>

#include <limits>

#include "heatmaps/rendered_heatmap.hpp"
#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

using test::every_method;
using test::Hits;
using test::is_true;
using test::rendered;

constexpr events::SensorSize sensor{20, 15};

TEST(HeatmapExtremes, OneEvent) {
  for (int y = 0; y < sensor.height; ++y) {
    for (int x = 0; x < sensor.width; ++x) {
      for (const HeatmapOptions& options : every_method()) ASSERT_TRUE(is_true({{.x = x, .y = y}}, sensor, options));
    }
  }
}

TEST(HeatmapExtremes, OneHotPixel) {
  for (const std::uint32_t count :
       {2U, 14U, 15U, 16U, 254U, 255U, 256U, 1'000U, 2'046U, 2'047U, 2'048U, 65'535U, 65'536U, 1'000'000U}) {
    for (const HeatmapOptions& options : every_method()) {
      ASSERT_TRUE(is_true({{.x = 7, .y = 7, .count = count}}, sensor, options));
      ASSERT_TRUE(is_true({{.x = 7, .y = 7, .count = count}, {.x = 12, .y = 2, .count = 1}}, sensor, options));
      ASSERT_TRUE(is_true({{.x = 7, .y = 7, .count = count}, {.x = 8, .y = 7, .count = 1}, {.x = 2, .y = 2, .count = 3}}, sensor,
                          options));
    }
  }
}

TEST(HeatmapExtremes, EveryPixelAtTheSameHugeCount) {
  for (const std::uint32_t count : {1U, 14U, 15U, 40U, 300U, 20'000U}) {
    std::vector<Hits> pixels;
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 10; ++x) pixels.push_back({x, y, count});
    }
    for (const HeatmapOptions& options : every_method()) {
      for (const std::uint8_t value : rendered<std::uint8_t>(pixels, {10, 10}, options)) EXPECT_EQ(value, 255);
      for (const float value : rendered<float>(pixels, {10, 10}, options)) EXPECT_FLOAT_EQ(value, 255.0F);
    }
  }
  std::vector<Hits> million;
  for (int i = 0; i < 4; ++i) million.push_back({i % 2, i / 2, 1'000'000});
  for (const HeatmapOptions& options : every_method(0.5)) EXPECT_EQ(rendered<std::uint8_t>(million, {2, 2}, options)[0], 255);
}

TEST(HeatmapExtremes, CountsOfAMillion) {
  const std::vector<std::vector<Hits>> extremes{
      {{.x = 2, .y = 2, .count = 1'000'000}, {.x = 7, .y = 7, .count = 999'999}, {.x = 12, .y = 12, .count = 999'990}},
      {{.x = 2, .y = 2, .count = 1'000'000}, {.x = 7, .y = 7, .count = 1'000'001}, {.x = 8, .y = 7, .count = 999'998}},
      {{.x = 2, .y = 2, .count = 1'000'000}, {.x = 3, .y = 2, .count = 500'000}, {.x = 7, .y = 7, .count = 2}},
      {{.x = 2, .y = 2, .count = 1'000'000}, {.x = 7, .y = 2, .count = 12}, {.x = 8, .y = 2, .count = 600}},
  };
  for (const auto& pixels : extremes) {
    for (const HeatmapOptions& options : every_method()) ASSERT_TRUE(is_true(pixels, sensor, options));
  }
}

TEST(HeatmapExtremes, WhereEveryDUnderflowsInFloat32OrInDouble) {
  for (const std::uint32_t count : {45U, 60U, 90U, 400U, 800U, 2'000U, 30'000U}) {
    const std::vector<Hits> pixels{{.x = 2, .y = 2, .count = count},
                                   {.x = 7, .y = 2, .count = count + 1},
                                   {.x = 12, .y = 2, .count = count + 3},
                                   {.x = 3, .y = 2, .count = count + 60},
                                   {.x = 17, .y = 12, .count = 2 * count}};
    for (const HeatmapOptions& options : every_method()) ASSERT_TRUE(is_true(pixels, sensor, options));
  }
}

TEST(HeatmapExtremes, ManyCountsAtOnce) {
  // Each pixel has a count of its own, so that nothing is shared.
  for (const std::uint32_t step : {1U, 7U, 150U}) {
    std::vector<Hits> pixels;
    for (std::uint32_t i = 0; i < 300; ++i)
      pixels.push_back({static_cast<int>(i % 20), static_cast<int>(i / 20), 1 + step * ((i * 77) % 300)});
    for (const HeatmapOptions& options : every_method()) ASSERT_TRUE(is_true(pixels, sensor, options));
  }
}

TEST(HeatmapExtremes, TimesNearTheEndsOfTheClock) {
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(), last = std::numeric_limits<std::int64_t>::max();
  for (const HeatmapOptions& options : every_method()) {
    HeatmapRenderer renderer(sensor, options);
    const auto expect_counts = [&](const std::vector<Hits>& pixels) {
      EXPECT_TRUE(is_true(renderer, test::dense_counts(pixels, sensor), sensor));
    };
    renderer.add(std::vector{events::Event{.t = camera_time(first), .x = 2, .y = 2},
                             events::Event{.t = camera_time(first + 1), .x = 7, .y = 2},
                             events::Event{.t = camera_time(first + 1), .x = 7, .y = 2}});
    renderer.move_to(camera_time(first));
    expect_counts({});
    renderer.move_to(camera_time(first + 1));  // its history would begin before the clock does
    expect_counts({{.x = 2, .y = 2}});
    renderer.move_to(camera_time(first + 40'000));
    expect_counts({{.x = 2, .y = 2}, {.x = 7, .y = 2, .count = 2}});
    renderer.move_to(camera_time(first + 40'001));
    expect_counts({{.x = 7, .y = 2, .count = 2}});
    renderer.add(std::vector{events::Event{.t = camera_time(last - 40'000), .x = 12, .y = 7},
                             events::Event{.t = camera_time(last - 1), .x = 17, .y = 7},
                             events::Event{.t = camera_time(last), .x = 2, .y = 12}});
    renderer.move_to(camera_time(last - 1));
    expect_counts({{.x = 12, .y = 7}});
    renderer.move_to(camera_time(last));  // an event at it belongs to the next
    expect_counts({{.x = 12, .y = 7}, {.x = 17, .y = 7}});
  }
}

}  // namespace
}  // namespace tactile::heatmaps
