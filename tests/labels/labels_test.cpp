#include "tactile/labels/labels.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {
namespace {

LabelledInterval interval(Touch touch, std::int64_t start_us, std::int64_t end_us) {
  const auto time = [](std::int64_t us) { return UncertainTime{camera_time(us), camera_time(us - 100), camera_time(us + 200)}; };
  LabelledInterval made;
  made.touch = touch;
  made.start = time(start_us);
  made.end = time(end_us);
  made.source = "events";
  return made;
}

TEST(Labels, SurviveTheWayThroughTheirFile) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 2'000), interval(Touch::slip, 3'000, 4'000)};
  labels.intervals[1].evidence.robot = camera_time(2'990);
  labels.intervals[1].confirmed = true;
  labels.robot_clock = FittedClock{
      .relation = {.offset_us = 5, .drift_ppm = 1.5, .reference_us = 7}, .residual_us = 2.5, .anchors = 2, .method = "m"};
  labels.flags = {{.interval_index = 1, .reason = "look", .confirmed = false},
                  {.interval_index = {}, .reason = "whole", .confirmed = true}};
  labels.provenance = {{"made_by", "a test"}};
  write_labels(folder / "labels.json", labels);

  const Labels read = read_labels(folder / "labels.json");
  ASSERT_EQ(read.intervals.size(), 2U);
  EXPECT_EQ(read.intervals[0].touch, Touch::press);
  EXPECT_EQ(read.intervals[0].start.low, camera_time(900));
  EXPECT_EQ(read.intervals[1].end.high, camera_time(4'200));
  EXPECT_EQ(read.intervals[1].evidence.robot, camera_time(2'990));
  EXPECT_FALSE(read.intervals[1].evidence.video.has_value());
  EXPECT_TRUE(read.intervals[1].confirmed);
  ASSERT_TRUE(read.robot_clock.has_value());
  EXPECT_EQ(read.robot_clock->relation.drift_ppm, 1.5);
  EXPECT_FALSE(read.video_clock.has_value());
  EXPECT_EQ(read.provenance, labels.provenance);
}

TEST(Labels, AreFlaggedOnlyWhileNobodyConfirmed) {
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 2'000), interval(Touch::slip, 3'000, 4'000)};
  labels.flags = {{.interval_index = 1, .reason = "look", .confirmed = false},
                  {.interval_index = {}, .reason = "whole", .confirmed = true}};
  EXPECT_FALSE(labels.run_is_flagged());
  EXPECT_FALSE(labels.interval_is_flagged(0));
  EXPECT_TRUE(labels.interval_is_flagged(1));
  labels.flags[1].confirmed = false;
  EXPECT_TRUE(labels.run_is_flagged());
}

TEST(Labels, ThatOverlapOrEndBeforeTheyStartAreRefused) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 3'500), interval(Touch::slip, 3'000, 4'000)};
  EXPECT_THROW(write_labels(folder / "labels.json", labels), Error);
  labels.intervals = {interval(Touch::press, 1'000, 900)};
  EXPECT_THROW(write_labels(folder / "labels.json", labels), Error);
}

TEST(Labels, FileOfAnotherKindIsRefusedByName) {
  const test::TemporaryFolder folder;
  write_json(folder / "labels.json", {{"intervals", "many"}});
  try {
    read_labels(folder / "labels.json");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("labels.json"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace tactile
