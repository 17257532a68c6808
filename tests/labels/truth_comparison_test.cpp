#include "tactile/labels/truth_comparison.hpp"

#include <gtest/gtest.h>

namespace tactile::labels {
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
  EXPECT_EQ(comparison.intervals[0].start, (Deviation{.error = 20us, .covered = true, .width = 100us}));
  EXPECT_EQ(comparison.intervals[0].end, (Deviation{.error = 10us, .covered = false, .width = 0us}));
  EXPECT_EQ(comparison.intervals[0].first_event, (Deviation{.error = 10us, .covered = true, .width = 100us}));
  EXPECT_EQ(comparison.intervals[1].start, (Deviation{.error = 100us, .covered = false, .width = 100us}));
  EXPECT_EQ(comparison.intervals[1].end, (Deviation{.error = 0us, .covered = true, .width = 0us}));
  EXPECT_TRUE(comparison.spurious.empty());
}

TEST(TruthComparison, FindsMissedAndSpurious) {
  Labels labels;
  labels.intervals = {found(Touch::slip, 1'020, 2'000)};
  Truth truth;
  truth.intervals = {truly(Touch::press, 1'000, 1'990)};
  const TruthComparison comparison = compare_with_truth(labels, truth);
  ASSERT_EQ(comparison.intervals.size(), 1U);
  EXPECT_FALSE(comparison.intervals[0].start.has_value());
  EXPECT_EQ(comparison.intervals[0].true_start, camera_time(1'000));
  ASSERT_EQ(comparison.spurious.size(), 1U);
  EXPECT_EQ(comparison.spurious[0].interval.start, camera_time(1'020));
}

TEST(TruthComparison, KeepsFlaggedApart) {
  Labels labels;
  labels.intervals = {found(Touch::press, 1'000, 2'000), found(Touch::slip, 3'000, 4'000), found(Touch::slip, 9'000, 9'500)};
  labels.flags = {{.interval_index = 1, .reason = "weak", .confirmed = false},
                  {.interval_index = 0, .reason = "looked at", .confirmed = true}};
  Truth truth;
  truth.intervals = {truly(Touch::press, 1'000, 2'000), truly(Touch::slip, 3'000, 4'000)};
  TruthComparison comparison = compare_with_truth(labels, truth);
  EXPECT_TRUE(comparison.flagged);
  EXPECT_FALSE(comparison.clocks_flagged);
  EXPECT_FALSE(comparison.intervals[0].flagged) << "a person lifted it";
  EXPECT_TRUE(comparison.intervals[1].flagged);
  EXPECT_FALSE(comparison.spurious.at(0).flagged);
  labels.flags = {{.interval_index = {}, .reason = "a gap", .confirmed = false}};
  comparison = compare_with_truth(labels, truth);
  EXPECT_TRUE(comparison.clocks_flagged);
  EXPECT_TRUE(comparison.intervals[0].flagged);
  EXPECT_TRUE(comparison.spurious.at(0).flagged);
  labels.flags.clear();
  EXPECT_FALSE(compare_with_truth(labels, truth).flagged);
}

alignment::FittedClock clock_found(std::int64_t offset_us, std::int64_t low_us, std::int64_t high_us) {
  alignment::FittedClock clock;
  clock.relation = {.offset_us = offset_us, .drift_ppm = 0, .reference_us = 0};
  clock.offset_low_us = low_us;
  clock.offset_high_us = high_us;
  return clock;
}

TEST(TruthComparison, ComparesTheLiftThroughTheFittedClocks) {
  Labels labels;
  labels.robot_clocks = {clock_found(1'030, 1'000, 1'100)};
  labels.video_clock = clock_found(500, 520, 600);
  Truth truth;
  truth.lift_start = camera_time(5'000);
  TruthComparison comparison = compare_with_truth(labels, truth);
  EXPECT_EQ(comparison.robot_clock, std::nullopt) << "a real robot, whose clock is not known";
  EXPECT_FALSE(comparison.robot_clock_sought);
  truth.robot_clock = {.offset_us = 1'000, .drift_ppm = 0, .reference_us = 0};
  truth.video_clock = {.offset_us = 510, .drift_ppm = 0, .reference_us = 0};
  comparison = compare_with_truth(labels, truth);
  EXPECT_EQ(comparison.robot_clock, (Deviation{.error = 30us, .covered = true, .width = 100us}));
  EXPECT_EQ(comparison.video_clock, (Deviation{.error = -10us, .covered = false, .width = 80us}));
  EXPECT_TRUE(comparison.robot_clock_sought);
  // The film's clock was found 4 ms before the lift, and drifts by up to a hundredth: 40 us as 30 us already, 50 us.
  labels.video_clock = clock_found(500, 470, 530);
  labels.video_clock->found_at_us = 500;
  labels.video_clock->drift_within_ppm = 10'000;
  truth.video_clock->offset_us = 545;
  EXPECT_EQ(compare_with_truth(labels, truth).video_clock, (Deviation{.error = -45us, .covered = true, .width = 100us}));
}

TEST(TruthComparison, ComparesClocksAtTheFirstTouchWhereThereIsNoLift) {
  Labels labels;
  labels.robot_clocks = {clock_found(1'000, 900, 1'100)};
  Truth truth;
  // 1000 ppm too fast: 1 ms after a second.
  truth.robot_clock = {.offset_us = 1'000, .drift_ppm = 1'000, .reference_us = 0};
  EXPECT_EQ(compare_with_truth(labels, truth).robot_clock, std::nullopt) << "no moment to compare at";
  truth.intervals = {truly(Touch::press, 1'002'000, 1'200'000)};
  const auto compared = compare_with_truth(labels, truth).robot_clock;
  ASSERT_TRUE(compared.has_value());
  EXPECT_EQ(compared->error, -1'000us);
  EXPECT_FALSE(compared->covered);
}

}  // namespace
}  // namespace tactile::labels
