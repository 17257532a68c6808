#include "tactile/experiments/trade/cost_growth.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/experiments/trade/dense_heatmaps.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::trade {
namespace {

constexpr events::SensorSize sensor{640, 480};

/// At random places, some of them hot, one a microsecond.
std::vector<events::Event> events_of(std::size_t count) {
  Random random(2);
  std::vector<events::Event> events(count);
  for (std::size_t i = 0; i < count; ++i) {
    const bool hot = random.below(4) == 0;
    events[i].x = static_cast<std::int16_t>(hot ? 33 : random.below(640));
    events[i].y = static_cast<std::int16_t>(hot ? 44 : random.below(480));
    events[i].t = camera_time(static_cast<std::int64_t>(i));
  }
  return events;
}

TEST(DenseHeatmaps, AreTheRenderersExceptForRounding) {
  const std::vector<events::Event> events = events_of(20'000);
  heatmaps::HeatmapRenderer renderer(sensor, {.history = 10ms, .tick = 2ms});
  DenseHeatmaps dense(sensor, 0.2);
  renderer.add(events);
  std::vector<std::uint8_t> heatmap(128 * 96);
  std::size_t there = 0, gone = 0;
  for (const std::int64_t tick : {10'000, 12'000, 18'000}) {
    renderer.move_to(camera_time(tick));
    renderer.render(std::span(heatmap));
    const auto until = static_cast<std::size_t>(tick), from = until - 10'000;
    dense.add(std::span(events).subspan(there, until - there));
    dense.forget(std::span(events).subspan(gone, from - gone));
    there = until, gone = from;
    dense.render();
    ASSERT_EQ(dense.heatmap().size(), heatmap.size());
    int lit = 0;
    for (std::size_t i = 0; i < heatmap.size(); ++i) {
      ASSERT_LE(std::abs(heatmap[i] - dense.heatmap()[i]), 1) << "cell " << i << " at " << tick;
      lit += heatmap[i] != 0 ? 1 : 0;
    }
    EXPECT_GT(lit, 1000);
  }
}

TEST(DenseHeatmaps, OfNoEventsAreEmpty) {
  DenseHeatmaps dense(sensor, 0.2);
  dense.render();
  for (const std::uint8_t cell : dense.heatmap()) ASSERT_EQ(cell, 0);
}

TEST(MeasureGrowth, HasAPointForEachPlaceAndBothWays) {
  const std::vector<events::Event> events = events_of(50'000);
  GrowthOptions options;
  options.rates = {0, 1e6};
  options.histories = {2ms, 4ms, 8ms};
  options.sensors = {{160, 120}};
  options.pieces = options.turns = 1;
  options.ticks = 2;
  const results::CostGrowth growth = measure_growth(events, sensor, options);
  ASSERT_EQ(growth.by_rate.size(), 2U);
  ASSERT_EQ(growth.by_history.size(), 3U);
  ASSERT_EQ(growth.by_resolution.size(), 1U);
  EXPECT_EQ(growth.by_rate[0].lit_share, 0);
  EXPECT_GT(growth.by_rate[1].lit_share, 0.1);
  EXPECT_EQ(growth.by_history[2].history, microseconds(8000));
  EXPECT_EQ(growth.by_resolution[0].heatmap, (events::SensorSize{32, 24}));
  for (const auto& point : {growth.by_rate[0], growth.by_rate[1], growth.by_history[0], growth.by_resolution[0]}) {
    for (const auto& time : {point.sparse, point.dense}) {
      EXPECT_GT(time.rendering_us, 0);
      EXPECT_GT(time.network_us, 0);
      EXPECT_GE(time.p99_us, time.p50_us);
    }
  }
  EXPECT_THROW(measure_growth({}, sensor, options), Error);
}

}  // namespace
}  // namespace tactile::trade
