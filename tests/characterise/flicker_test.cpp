#include "tactile/characterise/flicker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "characterise/made_sensor.hpp"

namespace tactile::characterise {
namespace {

constexpr double bin_us = 195.163;

/// A rate r (1 + depth sin(2 pi hz t)) in bins that average over their length.
Flicker flicker_of(double hz, double depth, double seconds, double events_per_bin, std::uint64_t seed) {
  FlickerMeter meter(bin_us, bin_us, microseconds{static_cast<std::int64_t>(1e6 * seconds)});
  Random random(seed);
  const double w = 2 * std::numbers::pi * hz * bin_us * 1e-6, phase = random.uniform(0, 7);
  for (std::int64_t i = 0; static_cast<double>(i) * bin_us < 1e6 * seconds; ++i) {
    const double mean =
        w > 0 ? (std::cos(w * static_cast<double>(i) + phase) - std::cos(w * static_cast<double>(i + 1) + phase)) / w : 0;
    const std::uint64_t n = random.poisson(events_per_bin * (1 + depth * mean));
    for (std::uint64_t k = 0; k < n; ++k) meter.add(i);
  }
  return meter.flicker();
}

TEST(Flicker, IsFoundWithItsFrequencyAndDepth) {
  for (const double hz : {100.0, 119.7, 733.3, 1950.0}) {
    const Flicker flicker = flicker_of(hz, 0.3, 4, 20, 1);
    ASSERT_EQ(flicker.lines.size(), 1U) << hz;
    EXPECT_NEAR(flicker.lines[0].hz.value, hz, 0.3) << hz;
    EXPECT_NEAR(flicker.lines[0].depth.value, 0.3, 0.03) << hz;
    EXPECT_LT(flicker.lines[0].chance, 1e-6) << hz;
  }
}

TEST(Flicker, OfPulsesIsOneSeriesOfItsFrequency) {
  Flicker flicker{.from_hz = 50, .to_hz = 2000, .lines = {}, .resolution_hz = 1, .spectrum = {}};
  for (const double hz : {60.0, 100.0, 120.3, 180.0, 230.0})
    flicker.lines.push_back({.hz = {hz, 0.02}, .depth = {1.9, 0.04}, .chance = 0, .lit_pixels = 9, .is_local = hz != 180});
  const std::vector<FlickerSeries> series = series_of(flicker);
  ASSERT_EQ(series.size(), 4U);
  EXPECT_EQ(series[0].line.hz.value, 60);
  EXPECT_EQ(series[0].multiples, 1U) << "120.3 Hz";
  EXPECT_EQ(series[1].line.hz.value, 100);
  EXPECT_EQ(series[2].line.hz.value, 180) << "of other pixels";
  EXPECT_EQ(series[3].line.hz.value, 230);
  EXPECT_EQ(series[3].multiples, 0U);
}

Flicker with_lines(const std::vector<double>& frequencies) {
  Flicker flicker{.from_hz = 50, .to_hz = 2000, .lines = {}, .resolution_hz = 1, .spectrum = {}};
  flicker.lines.reserve(frequencies.size());
  for (const double hz : frequencies) flicker.lines.push_back({.hz = {hz, 0.02}, .depth = {1.9, 0.04}});
  return flicker;
}

TEST(Flicker, OfPulsesBelowTheSearchedRangeHasTheirFrequency) {
  // Of 30 Hz without 150 Hz, and mains light.
  const auto series = series_of(with_lines({60.01, 89.99, 100, 120.02, 180, 210.01, 240}));
  ASSERT_EQ(series.size(), 2U);
  EXPECT_NEAR(series[0].line.hz.value, 30, 0.003);
  EXPECT_LT(series[0].line.hz.uncertainty, 0.004);
  EXPECT_EQ(series[0].multiples, 6U);
  EXPECT_EQ(series[1].line.hz.value, 100);
}

TEST(Flicker, IsNoSeriesOfWhichMostMultiplesAreMissing) {
  EXPECT_EQ(series_of(with_lines({100, 120})).size(), 2U) << "not 20 Hz: 60 and 80 Hz are missing";
  EXPECT_EQ(series_of(with_lines({60, 90.3})).size(), 2U) << "not 30 Hz: 0.3 Hz are 15 uncertainties";
  const auto series = series_of(with_lines({60, 120, 180}));
  ASSERT_EQ(series.size(), 1U);
  EXPECT_EQ(series[0].line.hz.value, 60) << "not 30 Hz";
}

TEST(Flicker, HasValuesWithinTheirUncertainty) {
  int hz_within = 0, depth_within = 0;
  constexpr int seeds = 60;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const double hz = 100 + 0.37 * static_cast<double>(seed);
    const Flicker flicker = flicker_of(hz, 0.1, 4, 20, 50 + seed);
    ASSERT_EQ(flicker.lines.size(), 1U) << seed;
    hz_within += test::off_by(flicker.lines[0].hz, hz) < 2;
    depth_within += test::off_by(flicker.lines[0].depth, 0.1) < 2;
  }
  EXPECT_GE(hz_within, 51) << "of 60; of normal errors 57";
  EXPECT_GE(depth_within, 51);
}

TEST(Flicker, IsNotFoundInNoise) {
  int lines = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) lines += static_cast<int>(flicker_of(0, 0, 2, 5, 1000 + seed).lines.size());
  EXPECT_LE(lines, 1) << "1 in 1000 recordings should have one";
}

TEST(Flicker, IsNotTheReadOut) {
  // Read-outs of 1 ms in bins of 125 us: nothing but multiples of 1000 Hz.
  FlickerMeter meter(125, 1000, std::chrono::seconds(4));
  Random random(2);
  for (std::int64_t i = 0; i < 32'000; i += 8) {
    const std::uint64_t n = random.poisson(40);
    for (std::uint64_t k = 0; k < n; ++k) meter.add(i);
  }
  EXPECT_TRUE(meter.flicker().lines.empty());
}

TEST(Flicker, IsSearchedUpToHalfTheRateOfReadOuts) {
  EXPECT_DOUBLE_EQ(flicker_of(100, 0.3, 1, 20, 1).to_hz, 2000);
  FlickerMeter slow(1000, 1000, std::chrono::seconds(4));
  for (std::int64_t i = 0; i < 4000; ++i) slow.add(i);
  EXPECT_DOUBLE_EQ(slow.flicker().to_hz, 500);
}

TEST(Flicker, IsNotSearchedInTooShortARecording) {
  FlickerMeter meter(bin_us, bin_us, std::chrono::milliseconds(20));
  for (std::int64_t i = 0; i < 100; ++i) meter.add(i);
  const Flicker flicker = meter.flicker();
  EXPECT_LE(flicker.to_hz, flicker.from_hz);
  EXPECT_TRUE(flicker.lines.empty());
}

TEST(Flicker, PassesOverSilences) {
  FlickerMeter meter(bin_us, bin_us, std::chrono::seconds(4));
  Random random(3);
  for (std::int64_t i = 0; i < 20'000; ++i) {
    const std::int64_t at = i < 10'000 ? i : i + 50'000'000;
    const std::uint64_t n = random.poisson(5);
    for (std::uint64_t k = 0; k < n; ++k) meter.add(at);
  }
  EXPECT_TRUE(meter.flicker().lines.empty());
}

}  // namespace
}  // namespace tactile::characterise
