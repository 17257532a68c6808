#include "tactile/alignment/activity.hpp"

#include <gtest/gtest.h>

#include "alignment/rate_of.hpp"

namespace tactile::alignment {
namespace {

using test::rate_of;

TEST(QuietRate, IsThatOfTheQuietHalfWhateverTheBursts) {
  const EventRate rate = rate_of(
      10'000, [](double t_us) { return t_us > 500'000 && t_us < 900'000 ? 200.0 : 3.0; }, 1);
  const QuietRate quiet = quiet_rate(rate);
  EXPECT_NEAR(quiet.mean, 3.0, 0.2);
  EXPECT_LT(quiet.dispersion, 2.0);
}

TEST(Bursts, AreFoundWhereTheRateRises) {
  const EventRate rate = rate_of(
      15'000,
      [](double t_us) { return (t_us > 600'000 && t_us < 800'000) || (t_us > 1'500'000 && t_us < 2'000'000) ? 30.0 : 3.0; }, 2);
  const auto bursts = bursts_in(rate, quiet_rate(rate));
  ASSERT_EQ(bursts.size(), 2U);
  EXPECT_NEAR(static_cast<double>(bursts[0].begin), 3'000, 20);
  EXPECT_NEAR(static_cast<double>(bursts[0].end), 4'000, 20);
  EXPECT_NEAR(static_cast<double>(bursts[1].begin), 7'500, 20);
  EXPECT_NEAR(static_cast<double>(bursts[1].end), 10'000, 20);
  EXPECT_NEAR(bursts[0].events, 27'000, 1'500);
}

TEST(Bursts, ThatStickInBetweenAreOne) {
  const EventRate rate = rate_of(
      10'000,
      [](double t_us) { return t_us > 500'000 && t_us < 1'000'000 && static_cast<int>(t_us / 50'000) % 2 == 0 ? 40.0 : 3.0; }, 3);
  EXPECT_EQ(bursts_in(rate, quiet_rate(rate)).size(), 1U);
}

TEST(Bursts, AreNotFoundInNoiseAlone) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const EventRate rate = rate_of(
        25'000, [](double) { return 3.0; }, seed);
    EXPECT_TRUE(bursts_in(rate, quiet_rate(rate)).empty()) << "seed " << seed;
  }
}

TEST(AfterEffect, IsABriefSmallBurstAndNoLightPress) {
  const EventRate rate{
      .begin = {}, .bin = 200us, .counts = {}, .hot_pixels = 0, .last = {}, .hot = {}, .saturated_bins = 0, .flicker_hz = {}};
  const std::vector<Burst> bursts = {{0, 500, 4'000}, {1'000, 1'150, 2'000}, {2'000, 5'000, 100'000}, {6'000, 6'150, 20'000}};
  EXPECT_FALSE(is_after_effect(bursts[0], rate, bursts));  // light, but as long as a stage takes
  EXPECT_TRUE(is_after_effect(bursts[1], rate, bursts));
  EXPECT_FALSE(is_after_effect(bursts[2], rate, bursts));
  EXPECT_FALSE(is_after_effect(bursts[3], rate, bursts));  // brief, but large
}

}  // namespace
}  // namespace tactile::alignment
