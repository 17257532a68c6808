#include "tactile/labels/human_edits.hpp"

#include <gtest/gtest.h>

#include "labels/exchange/exported.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::labels {
namespace {

using test::in_run;
using test::interval_of;

LabelledInterval persons(const std::string& id, Touch touch, std::int64_t start_us, std::int64_t end_us) {
  LabelledInterval interval = interval_of(id, touch, start_us, end_us);
  interval.source = "person";
  interval.confirmed = true;
  interval.evidence = {};
  interval.evidence.imu = in_run(7);
  return interval;
}

/// A file takes only intervals in order that do not overlap.
Labels kept(const Labels& fresh, const Labels& old) {
  const Labels labels = keep_human_edits(fresh, old);
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(write_labels(folder / "labels.json", labels));
  return labels;
}

Labels labels_of(std::vector<LabelledInterval> intervals) {
  Labels labels;
  labels.intervals = std::move(intervals);
  return labels;
}

TEST(HumanEdits, WithoutThemTheNewLabelsStay) {
  Labels old = labels_of({interval_of("press-1", Touch::press, 100, 200)});
  old.flags = {{.interval_index = {}, .reason = "old", .confirmed = false}};
  Labels fresh = labels_of({interval_of("press-1", Touch::press, 110, 210), interval_of("slip-1", Touch::slip, 300, 400)});
  fresh.flags = {{.interval_index = 1, .reason = "weak", .confirmed = false}};
  EXPECT_FALSE(has_human_edits(old));
  const Labels labels = kept(fresh, old);
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].start.at, in_run(110));
  ASSERT_EQ(labels.flags.size(), 1U);
  EXPECT_TRUE(labels.interval_is_flagged(1));
}

TEST(HumanEdits, APersonsIntervalStaysAndTakesTheEvidenceOfTheNewOne) {
  const Labels old = labels_of({persons("press-1", Touch::press, 150, 250), interval_of("slip-1", Touch::slip, 300, 400)});
  Labels fresh = labels_of({interval_of("press-1", Touch::press, 110, 210), interval_of("slip-1", Touch::slip, 310, 410)});
  fresh.robot_clocks.resize(1);
  fresh.robot_clocks[0].relation.offset_us = 77;
  fresh.flags = {{.interval_index = 0, .reason = "weak", .confirmed = false},
                 {.interval_index = 1, .reason = "late", .confirmed = false}};
  EXPECT_TRUE(has_human_edits(old));
  const Labels labels = kept(fresh, old);
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].start.at, in_run(150));
  EXPECT_EQ(labels.intervals[0].end.at, in_run(250));
  EXPECT_EQ(labels.intervals[0].source, "person");
  EXPECT_EQ(labels.intervals[0].evidence.events, in_run(110));
  EXPECT_EQ(labels.intervals[0].evidence.imu, in_run(7));
  EXPECT_EQ(labels.intervals[1].start.at, in_run(310));
  EXPECT_EQ(labels.robot_clocks.at(0).relation.offset_us, 77);
  EXPECT_FALSE(labels.interval_is_flagged(0));
  EXPECT_TRUE(labels.interval_is_flagged(1));
}

TEST(HumanEdits, AConfirmedIntervalStaysAsItWasSeen) {
  Labels old = labels_of({interval_of("press-1", Touch::press, 100, 200)});
  old.intervals[0].confirmed = true;
  const Labels labels = kept(labels_of({interval_of("press-1", Touch::press, 103, 205)}), old);
  ASSERT_EQ(labels.intervals.size(), 1U);
  EXPECT_EQ(labels.intervals[0].start.at, in_run(100));
  EXPECT_EQ(labels.intervals[0].source, "events");
  EXPECT_TRUE(labels.intervals[0].confirmed);
  EXPECT_EQ(labels.intervals[0].evidence.events, in_run(103));
}

TEST(HumanEdits, ARejectedIntervalIsNotFoundAgain) {
  Labels old;
  old.rejected = {{Touch::press, in_run(100), in_run(200)}};
  EXPECT_TRUE(has_human_edits(old));
  Labels fresh = labels_of({interval_of("press-1", Touch::press, 120, 220), interval_of("press-2", Touch::press, 250, 260),
                            interval_of("slip-1", Touch::slip, 300, 400)});
  fresh.flags = {{.interval_index = 0, .reason = "weak", .confirmed = false},
                 {.interval_index = 2, .reason = "late", .confirmed = false}};
  const Labels labels = kept(fresh, old);
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].id, "press-2");
  ASSERT_EQ(labels.flags.size(), 1U);
  EXPECT_TRUE(labels.interval_is_flagged(1));
  ASSERT_EQ(labels.rejected.size(), 1U);
}

TEST(HumanEdits, ANewOneOfAPersonsIdGetsAnother) {
  const Labels old = labels_of({persons("press-1", Touch::press, 500, 600)});
  const Labels labels = kept(labels_of({interval_of("press-1", Touch::press, 100, 200)}), old);
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].id, "press-2");
  EXPECT_EQ(labels.intervals[1].id, "press-1");
}

TEST(HumanEdits, ALaterStartEndsAnEarlierNewOne) {
  const Labels labels =
      kept(labels_of({interval_of("press-1", Touch::press, 100, 320)}), labels_of({persons("slip-1", Touch::slip, 300, 400)}));
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].end.at, in_run(300));
  EXPECT_TRUE(labels.flags.empty());
}

TEST(HumanEdits, ANewOneThatBeginsInAPersonsIsCutAndFlagged) {
  const Labels labels =
      kept(labels_of({interval_of("slip-1", Touch::slip, 290, 400)}), labels_of({persons("press-1", Touch::press, 100, 300)}));
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[1].start.at, in_run(300));
  EXPECT_TRUE(labels.interval_is_flagged(1));
  EXPECT_NE(labels.flags.at(0).reason.find("press-1"), std::string::npos);
}

TEST(HumanEdits, ANewOneMostlyInAPersonsOfAnotherClassIsDropped) {
  const Labels labels =
      kept(labels_of({interval_of("slip-1", Touch::slip, 250, 340)}), labels_of({persons("press-1", Touch::press, 100, 300)}));
  ASSERT_EQ(labels.intervals.size(), 1U);
  EXPECT_EQ(labels.intervals[0].touch, Touch::press);
  EXPECT_EQ(labels.intervals[0].evidence.events, std::nullopt);
}

TEST(HumanEdits, AConfirmedFlagStaysConfirmedIfItIsFoundAgain) {
  Labels old = labels_of({interval_of("press-1", Touch::press, 100, 200)});
  old.flags = {{.interval_index = 0, .reason = "weak", .confirmed = true},
               {.interval_index = {}, .reason = "no robot log", .confirmed = true}};
  EXPECT_TRUE(has_human_edits(old));
  Labels fresh = labels_of({interval_of("press-1", Touch::press, 110, 210), interval_of("press-2", Touch::press, 300, 310)});
  fresh.flags = {{.interval_index = 0, .reason = "weak", .confirmed = false},
                 {.interval_index = 1, .reason = "weak", .confirmed = false},
                 {.interval_index = {}, .reason = "no robot log", .confirmed = false},
                 {.interval_index = {}, .reason = "a gap of 5 ms", .confirmed = false}};
  const Labels labels = kept(fresh, old);
  EXPECT_FALSE(labels.interval_is_flagged(0));
  EXPECT_TRUE(labels.interval_is_flagged(1));
  EXPECT_TRUE(labels.flags.at(2).confirmed);
  EXPECT_FALSE(labels.flags.at(3).confirmed);
}

TEST(HumanEdits, AFlagIsFoundAgainByItsKeyWhateverItsWords) {
  Labels old = labels_of({interval_of("press-1", Touch::press, 100, 200)});
  old.flags = {{.interval_index = 0, .reason = "it's weak", .confirmed = true, .key = "weak 3"},
               {.interval_index = {}, .reason = "no robot log", .confirmed = true, .key = "no-robot-log"}};
  Labels fresh = labels_of({interval_of("press-1", Touch::press, 110, 210)});
  fresh.flags = {flag_of(doubt("weak", "weak: {} events", 3), 0), flag_of(doubt("weak", "weak: {} events", 4), 0),
                 flag_of(doubt("other", "no robot log"))};
  const Labels labels = kept(fresh, old);
  EXPECT_TRUE(labels.flags.at(0).confirmed);
  EXPECT_FALSE(labels.flags.at(1).confirmed) << "another value";
  EXPECT_FALSE(labels.flags.at(2).confirmed) << "another kind";
}

TEST(HumanEdits, AMereInstantWithinAPersonsIntervalIsDropped) {
  const Labels labels =
      kept(labels_of({interval_of("slip-1", Touch::slip, 200, 200)}), labels_of({persons("press-1", Touch::press, 100, 300)}));
  EXPECT_EQ(labels.intervals.size(), 1U);
}

}  // namespace
}  // namespace tactile::labels
