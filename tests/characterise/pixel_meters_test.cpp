#include "tactile/characterise/pixel_meters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tactile/core/random.hpp"

namespace tactile::characterise {
namespace {

TEST(Neighbours, CorrelateFullyIfTheyAlwaysFireTogether) {
  // Pixels 0 and 1 of a row of four fire together in every second tick, the others never.
  NeighbourMeter meter({2, 1}, std::vector<bool>(2, true));
  for (int part = 0; part < 4; ++part) {
    meter.begin_part();
    for (std::int64_t tick = 100 * part; tick < 100 * (part + 1); tick += 2) {
      meter.add(0, tick);
      meter.add(1, tick);
    }
  }
  meter.end_recording(400);
  EXPECT_NEAR(meter.neighbours().horizontal.value, 1, 1e-9);
}

TEST(Neighbours, DoNotCorrelateIfEachPixelFiresByItself) {
  NeighbourMeter meter({20, 20}, std::vector<bool>(400, true));
  Random random(1);
  for (int part = 0; part < 20; ++part) {
    meter.begin_part();
    for (std::int64_t tick = 500 * part; tick < 500 * (part + 1); ++tick) {
      for (std::uint64_t n = random.poisson(10); n > 0; --n) meter.add(random.below(400), tick);
    }
  }
  meter.end_recording(10'000);
  const Neighbours neighbours = meter.neighbours();
  EXPECT_LT(std::abs(neighbours.horizontal.value), 3 * neighbours.horizontal.uncertainty);
  EXPECT_LT(std::abs(neighbours.vertical.value), 3 * neighbours.vertical.uncertainty);
  EXPECT_LT(neighbours.vertical.uncertainty, 0.01);
}

TEST(Neighbours, AreSeenAcrossAndDownApart) {
  NeighbourMeter meter({10, 10}, std::vector<bool>(100, true));
  Random random(2);
  for (int part = 0; part < 20; ++part) {
    meter.begin_part();
    for (std::int64_t tick = 500 * part; tick < 500 * (part + 1); ++tick) {
      const std::uint64_t pixel = random.below(90);
      meter.add(pixel, tick);
      if (random.uniform() < 0.5) meter.add(pixel + 10, tick);  // the pixel below
    }
  }
  meter.end_recording(10'000);
  EXPECT_GT(meter.neighbours().vertical.value, 0.2);
  EXPECT_NEAR(meter.neighbours().horizontal.value, 0, 0.03);
}

TEST(Intervals, HaveTheDeadTimeAsTheirShortest) {
  IntervalMeter meter(50);
  Random random(3);
  for (std::size_t pixel = 0; pixel < 50; ++pixel) {
    for (double t = 0; t < 1e6; t += 340 + 2000 * random.exponential()) meter.add(pixel, static_cast<std::int64_t>(t));
  }
  const auto shortest = meter.shortest_us();
  ASSERT_TRUE(shortest);
  EXPECT_NEAR(shortest->value, 340, std::max(2.0, 2 * shortest->uncertainty));
}

TEST(Intervals, OfFewEventsDecideNothing) {
  IntervalMeter meter(2);
  EXPECT_FALSE(meter.add(0, 100));
  EXPECT_EQ(meter.add(0, 350), 250);
  EXPECT_FALSE(meter.add(0, 300)) << "a step back";
  EXPECT_FALSE(meter.add(1, 400)) << "the first of another pixel";
  EXPECT_FALSE(meter.shortest_us());
  meter.begin_recording();
  EXPECT_FALSE(meter.add(0, 500)) << "the first of another recording";
}

TEST(LargestCounts, AreThoseOfASlowCount) {
  LargestCountMeter meter(30);
  meter.begin_recording();
  std::map<std::size_t, std::map<std::int64_t, std::uint32_t>> counts;
  Random random(4);
  std::uint32_t most_in_tick = 0, most_in_history = 0;
  for (std::int64_t tick = 0; tick < 2000; tick += 1 + static_cast<std::int64_t>(random.below(random.below(40) == 0 ? 60 : 2))) {
    for (std::uint64_t n = random.poisson(6); n > 0; --n) {
      const std::size_t pixel = random.below(1 + random.below(30));
      ++counts[pixel][tick];
      meter.add(pixel, tick, true);
    }
  }
  for (const auto& [pixel, ticks] : counts) {
    for (const auto& [tick, count] : ticks) {
      most_in_tick = std::max(most_in_tick, count);
      std::uint32_t history = 0;
      for (const auto& [other, n] : ticks) history += other > tick - 20 && other <= tick ? n : 0;
      most_in_history = std::max(most_in_history, history);
    }
  }
  EXPECT_EQ(meter.all().tick.value, most_in_tick);
  EXPECT_EQ(meter.all().history.value, most_in_history);
}

TEST(LargestCounts, AreSeparateForOrdinaryPixelsAndRecordings) {
  LargestCountMeter meter(2);
  meter.begin_recording();
  for (int i = 0; i < 9; ++i) meter.add(0, 5, false);
  for (int i = 0; i < 3; ++i) meter.add(1, 5, true);
  meter.begin_recording();
  meter.add(1, 0, true);
  EXPECT_EQ(meter.all().tick.value, 9);
  EXPECT_EQ(meter.ordinary().tick.value, 3);
  EXPECT_EQ(meter.ordinary().history.value, 3) << "what another recording had does not count";
}

TEST(LargestCounts, ScatterAsThoseOfTheParts) {
  LargestCountMeter meter(1);
  meter.begin_recording();
  for (int part = 0; part < 3; ++part) {  // 2, 4 and 6 events in one tick
    meter.begin_part();
    for (int i = 0; i < 2 * (part + 1); ++i) meter.add(0, 100 * part, true);
  }
  EXPECT_EQ(meter.all().tick.value, 6);
  EXPECT_DOUBLE_EQ(meter.all().tick.uncertainty, 2);
}

}  // namespace
}  // namespace tactile::characterise
