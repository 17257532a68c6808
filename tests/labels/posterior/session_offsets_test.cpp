#include "tactile/labels/posterior/session_offsets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tactile::labels {
namespace {

/// A run a minute after the one before, whose offset is 1 s with a drift of 50 ppm, and likely another one, too.
OffsetsOfRun run_at(int minute, std::int64_t wrong_us, double wrong) {
  const std::int64_t us = 1'000'000 + 3'000 * minute;
  return {.at = RobotTime{} + std::chrono::minutes{minute},
          .offsets = {{us, std::log(1 - wrong)}, {us + wrong_us, std::log(wrong)}}};
}

double share_near(const std::vector<WeighedOffset>& offsets, std::int64_t us) {
  double sum = 0;
  for (const WeighedOffset& one : offsets) sum += std::abs(one.us - us) < 15'000 ? std::exp(one.log_weight) : 0;
  return sum;
}

TEST(SessionOffsets, AreThoseOfTheOtherRunsWithTheirDrift) {
  const std::vector<OffsetsOfRun> runs{run_at(0, 400'000, 0.3), run_at(1, -700'000, 0.4), run_at(2, 900'000, 0.2),
                                       run_at(3, 150'000, 0.9)};
  const auto others = offsets_by_others(runs);
  ASSERT_EQ(others.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_GT(share_near(others[static_cast<std::size_t>(i)], 1'000'000 + 3'000 * i), 0.95) << i;
    double sum = 0;
    for (const WeighedOffset& one : others[static_cast<std::size_t>(i)]) sum += std::exp(one.log_weight);
    EXPECT_NEAR(sum, 1, 1e-9);
  }
}

TEST(SessionOffsets, OfARestartedControllerDoNotMoveTheOthers) {
  std::vector<OffsetsOfRun> runs{run_at(0, 400'000, 0.01), run_at(1, 400'000, 0.01), run_at(2, 400'000, 0.01)};
  runs.push_back({.at = RobotTime{} + std::chrono::minutes{3}, .offsets = {{-50'000'000, 0.0}}});
  EXPECT_GT(share_near(offsets_by_others(runs)[0], 1'000'000), 0.9);
}

TEST(SessionOffsets, OfARunAloneAreUnknown) {
  EXPECT_TRUE(offsets_by_others(std::vector{run_at(0, 1, 0.5)})[0].empty());
  const std::vector<OffsetsOfRun> without_log{run_at(0, 1, 0.5), {}};
  EXPECT_TRUE(offsets_by_others(without_log)[0].empty());
  EXPECT_FALSE(offsets_by_others(without_log)[1].empty());
}

TEST(SessionOffsets, HaveADensityThatSumsToOne) {
  const std::vector<WeighedOffset> offsets{{0, std::log(0.25)}, {20'000, std::log(0.75)}};
  double sum = 0;
  for (int i = -6000; i < 6000; ++i) sum += 500 * std::exp(log_density(offsets, 500.0 * i));
  EXPECT_NEAR(sum, 1, 1e-3);
}

}  // namespace
}  // namespace tactile::labels
