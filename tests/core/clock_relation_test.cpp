#include "tactile/core/clock_relation.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tactile {
namespace {

TEST(ClockRelation, ShiftsByTheOffsetAndStretchesByTheDrift) {
  const ClockRelation relation{.offset_us = 1'000, .drift_ppm = 100.0, .reference_us = 5'000'000};
  EXPECT_EQ(relation.camera_from(5'000'000), camera_time(5'001'000));
  EXPECT_EQ(relation.camera_from(15'000'000), camera_time(15'002'000));
}

TEST(ClockRelation, ReadsBackwardsToWithinAMicrosecond) {
  const ClockRelation relation{.offset_us = -7'777'777, .drift_ppm = -93.5, .reference_us = 123};
  for (const std::int64_t clock_us : {0LL, 123LL, 9'999'999LL, 86'400'000'000LL}) {
    EXPECT_NEAR(static_cast<double>(relation.clock_us_from(relation.camera_from(clock_us)) - clock_us), 0.0, 1.0);
  }
}

TEST(ClockRelation, HoldsAtTheEndsOfTime) {
  const ClockRelation relation{.offset_us = 10, .drift_ppm = 0.0, .reference_us = 0};
  EXPECT_EQ(relation.camera_from(std::numeric_limits<std::int64_t>::max()), CameraTime::max());
}

TEST(ClockRelation, HoldsForAnyDrift) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  ClockRelation relation{.offset_us = 0, .drift_ppm = 1e15, .reference_us = 0};
  EXPECT_EQ(relation.camera_from(highest), CameraTime::max());
  EXPECT_EQ(relation.camera_from(lowest), CameraTime::min());
  EXPECT_GT(relation.camera_from(1'000'000'000'000), camera_time(highest / 2)) << "far ahead, not at the other end";
  relation.drift_ppm = -1e15;
  EXPECT_LT(relation.camera_from(1'000'000'000'000), camera_time(lowest / 2));
  relation.drift_ppm = -1e6;  // a clock that stands has no inverse
  EXPECT_EQ(relation.camera_from(5), camera_time(0));
  EXPECT_EQ(relation.clock_us_from(camera_time(0)), 0);
}

TEST(ClockRelation, SurvivesTheWayThroughJson) {
  const ClockRelation relation{.offset_us = 42, .drift_ppm = 12.25, .reference_us = -3};
  const auto read = nlohmann::json(relation).get<ClockRelation>();
  EXPECT_EQ(read.offset_us, 42);
  EXPECT_EQ(read.drift_ppm, 12.25);
  EXPECT_EQ(read.reference_us, -3);
}

}  // namespace
}  // namespace tactile
