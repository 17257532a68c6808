#include "tactile/labels/unlabelled_bursts.hpp"

#include <gtest/gtest.h>

#include "labels/made_bursts.hpp"

namespace tactile::labels {
namespace {

TEST(UnlabelledBursts, AreDoubtfulAfterTheSlipIfTheyHaveHalfTheEventsOfThePress) {
  alignment::RunSignals signals;
  signals.rate = quiet_rate;
  const std::vector<alignment::Burst> made = {burst(500, 700, 50'000), burst(1'200, 1'800, 200'000), burst(2'000, 2'300, 30'000),
                                              burst(2'600, 2'900, 20'000)};
  const std::vector<BurstKind> of_them = {BurstKind::press, BurstKind::slip, BurstKind::after, BurstKind::after};
  const UnlabelledBursts unlabelled = unlabelled_bursts(signals, {}, {}, made, of_them, {});
  ASSERT_EQ(unlabelled.doubts.size(), 1U);
  EXPECT_EQ(unlabelled.doubts[0].words, "no label explains the burst of events from 2.00 s to 2.30 s");
  EXPECT_EQ(unlabelled.remark, "bursts of events without a label: 2.60 s to 2.90 s (after the slip)");
}

}  // namespace
}  // namespace tactile::labels
