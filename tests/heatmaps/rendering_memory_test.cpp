#include <gtest/gtest.h>

#include "events/counted_memory.hpp"
#include "heatmaps/rendered_heatmap.hpp"
#include "tactile/core/random.hpp"

namespace tactile::heatmaps {
namespace {

/// Ticks of one pattern of events that repeats; how often memory was asked for in the second half of them.
std::size_t requests_once_warm(events::SensorSize sensor, const HeatmapOptions& options) {
  Random random(1);
  std::vector<events::Event> pattern;
  for (int i = 0; i < 700; ++i) {
    const bool is_hot = i % 7 == 0;
    pattern.push_back({.t = {},
                       .x = static_cast<std::int16_t>(is_hot ? 3 : random.below(static_cast<std::uint64_t>(sensor.width))),
                       .y = static_cast<std::int16_t>(is_hot ? 3 : random.below(static_cast<std::uint64_t>(sensor.height)))});
  }
  HeatmapRenderer renderer(sensor, options);
  const auto size = static_cast<std::size_t>(renderer.size().width * renderer.size().height);
  std::vector<std::uint8_t> bytes(size);
  std::vector<float> floats(size);
  std::size_t before = 0;
  for (std::int64_t tick = 1; tick <= 200; ++tick) {
    if (tick == 101) before = test::memory_requests;
    for (events::Event& event : pattern) event.t = camera_time(tick * options.tick.count() - 1);
    renderer.add(pattern);
    renderer.move_to(camera_time(tick * options.tick.count()));
    renderer.render(std::span(bytes));
    renderer.render(std::span(floats));
  }
  const std::size_t requests = test::memory_requests - before;
  EXPECT_NE(bytes, std::vector<std::uint8_t>(size));
  return requests;
}

TEST(RenderingMemory, IsNotAskedForOnceWarm) {
  for (const double factor : {0.2, 1.0 / 20}) {
    for (const HeatmapOptions& options : test::every_method(factor)) EXPECT_EQ(requests_once_warm({346, 260}, options), 0U);
  }
  EXPECT_GT(test::memory_requests, 0U);  // they are counted
}

TEST(RenderingMemory, FollowsTheLargestWindowAndNotTheRecording) {
  HeatmapRenderer renderer({64, 48}, {});
  std::vector<events::Event> events(1000);
  const std::size_t before = test::memory_requests;
  for (std::int64_t tick = 1; tick <= 5'000; ++tick) {
    for (events::Event& event : events) event.t = camera_time(tick * 2'000 - 1);
    renderer.add(events);
    renderer.move_to(camera_time(tick * 2'000));
  }
  EXPECT_EQ(renderer.events(), 20'000U);
  EXPECT_LT(test::memory_requests - before, 60U);  // doubled until the window fitted
}

}  // namespace
}  // namespace tactile::heatmaps
