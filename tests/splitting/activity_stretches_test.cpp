#include "tactile/splitting/activity_stretches.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tactile::splitting {
namespace {

/// Bins of 1 ms with Poisson noise.
class ActivityIn : public testing::Test {
 protected:
  ActivityIn() { rate.bin = 1ms; }

  void add(double seconds, double events_per_ms) {
    std::poisson_distribution<std::uint32_t> noise(events_per_ms);
    for (int i = 0; i < static_cast<int>(1'000 * seconds); ++i) rate.counts.push_back(events_per_ms > 0 ? noise(random) : 0U);
  }

  alignment::EventRate rate;
  std::mt19937 random{3};
};

TEST_F(ActivityIn, FindsBurstsAboveAQuietRateThatDriftsOverMinutes) {
  // The light doubles the noise within six minutes. Against one quiet rate, the end would be one burst.
  std::vector<std::size_t> begins;
  for (int i = 0; i < 36; ++i) {
    add(9.8, 50.0 + 1.5 * i);
    begins.push_back(rate.counts.size());
    add(0.2, 50.0 + 1.5 * i + 100.0);
  }
  const LongActivity found = activity_in(rate);
  ASSERT_EQ(found.bursts.size(), 36U);
  for (std::size_t i = 0; i < 36; ++i) {
    EXPECT_NEAR(static_cast<double>(found.bursts[i].begin), static_cast<double>(begins[i]), 5.0);
    EXPECT_NEAR(static_cast<double>(found.bursts[i].end), static_cast<double>(begins[i] + 200), 5.0);
  }
  EXPECT_GT(found.quiet.mean, 50.0);
  EXPECT_LT(found.quiet.mean, 104.0);
}

TEST_F(ActivityIn, FindsABurstAcrossTheBoundaryOfTwoPartsOnce) {
  add(59.9, 50.0);
  add(0.3, 200.0);
  add(40.0, 50.0);
  const LongActivity found = activity_in(rate);
  ASSERT_EQ(found.bursts.size(), 1U);
  EXPECT_NEAR(static_cast<double>(found.bursts[0].end), 60'200.0, 5.0);
}

TEST_F(ActivityIn, TakesTheQuietRateOfEachStretchBetweenPauses) {
  // Nothing was recorded for 30 s between runs of 4 s. The noise of a run is no burst against those pauses.
  for (int i = 0; i < 3; ++i) {
    add(2.0, 80.0);
    add(0.3, 300.0);
    add(1.7, 80.0);
    add(30.0, 0.0);
  }
  const LongActivity found = activity_in(rate);
  ASSERT_EQ(found.bursts.size(), 3U);
  EXPECT_NEAR(static_cast<double>(found.bursts[1].begin), 36'000.0, 5.0);
  EXPECT_NEAR(found.quiet.mean, 80.0, 5.0);
  ASSERT_EQ(found.pauses.size(), 2U);
  EXPECT_NEAR(static_cast<double>(found.pauses[0].begin), 4'000.0, 5.0);
  EXPECT_NEAR(static_cast<double>(found.pauses[0].end), 34'000.0, 5.0);
}

TEST_F(ActivityIn, TakesAStretchOfASilentSensorForABurst) {
  for (int i = 0; i < 2; ++i) {
    add(3.0, 0.0);
    add(0.2, 30.0);
  }
  add(2.0, 0.0);
  add(0.01, 3.0);  // some 30 events are no touch
  add(2.0, 0.0);
  const LongActivity found = activity_in(rate);
  ASSERT_EQ(found.bursts.size(), 2U);
  EXPECT_EQ(found.bursts[0].begin, 3'000U);
}

TEST_F(ActivityIn, HasNoneInNoiseAlone) {
  add(130.0, 60.0);
  EXPECT_TRUE(activity_in(rate).bursts.empty());
  const LongActivity none = activity_in(alignment::EventRate{.bin = 1ms});
  EXPECT_TRUE(none.bursts.empty());
  EXPECT_FALSE(none.has_quiet);
}

}  // namespace
}  // namespace tactile::splitting
