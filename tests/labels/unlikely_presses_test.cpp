#include "tactile/labels/unlikely_presses.hpp"

#include <gtest/gtest.h>

namespace tactile::labels {
namespace {

LabelledInterval interval(Touch touch, std::int64_t start_ms, std::int64_t end_ms) {
  const auto at = [](std::int64_t ms) {
    const CameraTime t = camera_time(1000 * ms);
    return alignment::UncertainTime{t, t, t};
  };
  return {
      .id = {}, .touch = touch, .start = at(start_ms), .end = at(end_ms), .source = "events", .evidence = {}, .confirmed = false};
}

TEST(UnlikelyPresses, AreShorterThanAPressOrFollowOneWithoutARelease) {
  Labels labels;
  labels.intervals = {interval(Touch::press, 100, 300), interval(Touch::press, 800, 1100), interval(Touch::slip, 1500, 2000),
                      interval(Touch::press, 2200, 2206)};
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
  labels.intervals = {interval(Touch::press, 100, 300), interval(Touch::press, 800, 1100)};
  labels.releases = {{Touch::none, camera_time(500'000), camera_time(700'000)}};
  EXPECT_TRUE(unlikely_presses(labels).empty());
  labels.releases = {{Touch::none, camera_time(900'000), camera_time(950'000)}};
  EXPECT_EQ(unlikely_presses(labels).size(), 1U) << "the release comes later";
}

}  // namespace
}  // namespace tactile::labels
