#include "tactile/labels/unlikely_presses.hpp"

#include <gtest/gtest.h>

#include "labels/made_interval.hpp"

namespace tactile::labels {
namespace {

using test::made_interval;

TEST(UnlikelyPresses, AreShorterThanAPressOrFollowOneWithoutARelease) {
  Labels labels;
  labels.intervals = {made_interval(Touch::press, 100, 300), made_interval(Touch::press, 800, 1100),
                      made_interval(Touch::slip, 1500, 2000), made_interval(Touch::press, 2200, 2206)};
  const std::vector<LabelFlag> flags = unlikely_presses(labels);
  ASSERT_EQ(flags.size(), 2U);
  EXPECT_EQ(flags[0].interval_index, 1U);
  EXPECT_EQ(
      flags[0].reason,
      "it follows a press without a release between them: the object may have turned or slipped in part, or this is the rest "
      "of that press (then reject it)");
  EXPECT_EQ(flags[1].interval_index, 3U) << "after a slip the object may have left";
  EXPECT_EQ(flags[1].reason, "the press lasts 6 ms; expected 20 ms or more");
}

TEST(UnlikelyPresses, AreNoSecondPressesAfterARelease) {
  Labels labels;
  labels.intervals = {made_interval(Touch::press, 100, 300), made_interval(Touch::press, 800, 1100)};
  labels.releases = {{Touch::none, camera_time(500'000), camera_time(700'000)}};
  EXPECT_TRUE(unlikely_presses(labels).empty());
  labels.releases = {{Touch::none, camera_time(900'000), camera_time(950'000)}};
  EXPECT_EQ(unlikely_presses(labels).size(), 1U) << "the release comes later";
}

}  // namespace
}  // namespace tactile::labels
