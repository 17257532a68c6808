#include "tactile/labels/truth_comparison.hpp"

#include <gtest/gtest.h>

namespace tactile {
namespace {

LabelledInterval found(Touch touch, std::int64_t start_us, std::int64_t end_us) {
  LabelledInterval interval;
  interval.touch = touch;
  interval.start = {camera_time(start_us), camera_time(start_us - 50), camera_time(start_us + 50)};
  interval.end = {camera_time(end_us), camera_time(end_us), camera_time(end_us)};
  return interval;
}

TrueInterval truly(Touch touch, std::int64_t start_us, std::int64_t end_us, bool labelled = true) {
  TrueInterval interval;
  interval.interval = {touch, camera_time(start_us), camera_time(end_us)};
  interval.first_event = camera_time(start_us + 10);
  interval.labelled = labelled;
  return interval;
}

TEST(TruthComparison, PairsByClassAndOverlap) {
  Labels labels;
  labels.intervals = {found(Touch::press, 1'020, 2'000), found(Touch::slip, 3'100, 4'000)};
  Truth truth;
  truth.intervals = {truly(Touch::press, 1'000, 1'990), truly(Touch::slip, 3'000, 4'000),
                     truly(Touch::slip, 5'000, 5'100, false)};
  const TruthComparison comparison = compare_with_truth(labels, truth);
  ASSERT_EQ(comparison.intervals.size(), 2U) << "unlabelled truth is not compared";
  EXPECT_EQ(comparison.intervals[0].start_error, 20us);
  EXPECT_EQ(comparison.intervals[0].end_error, 10us);
  EXPECT_EQ(comparison.intervals[0].first_event_error, 10us);
  EXPECT_TRUE(comparison.intervals[0].covered);
  EXPECT_EQ(comparison.intervals[1].start_error, 100us);
  EXPECT_FALSE(comparison.intervals[1].covered);
  EXPECT_EQ(comparison.spurious, 0U);
}

TEST(TruthComparison, CountsMissedAndSpurious) {
  Labels labels;
  labels.intervals = {found(Touch::slip, 1'020, 2'000)};
  Truth truth;
  truth.intervals = {truly(Touch::press, 1'000, 1'990)};
  const TruthComparison comparison = compare_with_truth(labels, truth);
  EXPECT_FALSE(comparison.intervals[0].start_error.has_value());
  EXPECT_EQ(comparison.spurious, 1U);
}

TEST(TruthComparison, BringsTheLiftThroughTheFittedClock) {
  Labels labels;
  labels.robot_clocks = {
      {.relation = {.offset_us = 1'030, .drift_ppm = 0, .reference_us = 0}, .residual_us = 1, .anchors = 1, .method = ""}};
  Truth truth;
  truth.lift_start = camera_time(5'000);
  EXPECT_EQ(compare_with_truth(labels, truth).robot_clock_error, std::nullopt) << "a real robot, whose clock nobody knows";
  truth.robot_clock = {.offset_us = 1'000, .drift_ppm = 0, .reference_us = 0};
  EXPECT_EQ(compare_with_truth(labels, truth).robot_clock_error, 30us);
}

}  // namespace
}  // namespace tactile
