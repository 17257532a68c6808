#include "tactile/labels/exchange/import_edits.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "labels/exchange/exported.hpp"
#include "support/error_of.hpp"

namespace tactile::labels {
namespace {

using test::in_run;

/// The three intervals of `exported_run`, as a tool with whole milliseconds gives them back.
ImportedLabels in_milliseconds() {
  ImportedLabels imported{.where = "labels.csv"};
  const auto add = [&](const char* id, Touch touch, std::int64_t start_ms, std::int64_t end_ms) {
    imported.intervals.push_back({.id = id,
                                  .touch = touch,
                                  .start_us = start_ms * 1000,
                                  .end_us = end_ms * 1000,
                                  .start_rounding_us = 1000,
                                  .end_rounding_us = 1000,
                                  .where = "labels.csv"});
  };
  add("press-1", Touch::press, 930, 1067);
  add("press-2", Touch::press, 1100, 1201);
  add("slip-1", Touch::slip, 1484, 1988);
  return imported;
}

class WithEdits : public testing::Test {
 protected:
  Labels edited(const ImportedLabels& imported) {
    return with_edits(run.labels, imported, run.times, run.first_event, run.last_event, counts);
  }
  LabelsToExport run = test::exported_run();
  EditCounts counts;
};

TEST_F(WithEdits, RoundingToAMillisecondMovesNothing) {
  const Labels labels = edited(in_milliseconds());
  EXPECT_EQ(counts.kept, 3U);
  EXPECT_EQ(counts.edits(), 0U);
  EXPECT_EQ(labels.intervals[0].start.at, in_run(929'637));
  EXPECT_EQ(labels.intervals[0].source, "events");
  EXPECT_FALSE(labels.intervals[0].confirmed);
}

TEST_F(WithEdits, AMovedEndIsThePersonsAndTheOtherStaysExact) {
  ImportedLabels imported = in_milliseconds();
  imported.intervals[2].end_us = 1'950'000;
  const Labels labels = edited(imported);
  EXPECT_EQ(counts.moved, 1U);
  const LabelledInterval& slip = labels.intervals[2];
  EXPECT_EQ(slip.id, "slip-1");
  EXPECT_EQ(slip.source, "person");
  EXPECT_TRUE(slip.confirmed);
  EXPECT_EQ(slip.start.at, in_run(1'484'400));
  EXPECT_EQ(slip.start.low, in_run(1'483'700));
  EXPECT_EQ(slip.end.at, in_run(1'950'000));
  EXPECT_EQ(slip.end.low, in_run(1'949'000));
  EXPECT_EQ(slip.end.high, in_run(1'951'000));
  EXPECT_EQ(slip.evidence.robot, in_run(1'479'277));
}

TEST_F(WithEdits, ANewOneGetsAnIdAndOneThatIsGoneIsRejected) {
  ImportedLabels imported = in_milliseconds();
  imported.intervals.erase(imported.intervals.begin());
  imported.intervals.push_back({.id = "a7", .touch = Touch::press, .start_us = 2'100'000, .end_us = 2'300'000, .where = "w"});
  const Labels labels = edited(imported);
  EXPECT_EQ(counts.added, 1U);
  EXPECT_EQ(counts.rejected, 1U);
  ASSERT_EQ(labels.intervals.size(), 3U);
  EXPECT_EQ(labels.intervals[2].touch, Touch::press);
  EXPECT_FALSE(labels.intervals[2].id.empty());
  EXPECT_NE(labels.intervals[2].id, "press-2");
  EXPECT_EQ(labels.intervals[2].source, "person");
  EXPECT_TRUE(labels.intervals[2].confirmed);
  ASSERT_EQ(labels.rejected.size(), 1U);
  EXPECT_EQ(labels.rejected[0].touch, Touch::press);
  EXPECT_EQ(labels.rejected[0].start, in_run(929'637));
  EXPECT_EQ(labels.rejected[0].end, in_run(1'067'241));
}

TEST_F(WithEdits, TheSameFileAgainChangesNothing) {
  ImportedLabels imported = in_milliseconds();
  imported.intervals[0].end_us = 1'050'000;
  imported.intervals.erase(imported.intervals.begin() + 1);
  imported.intervals.push_back({.id = "", .touch = Touch::press, .start_us = 2'100'000, .end_us = 2'300'000, .where = "w"});
  run.labels = edited(imported);
  const Labels again = edited(imported);
  EXPECT_EQ(counts.kept, 3U);
  EXPECT_EQ(counts.edits(), 0U);
  EXPECT_EQ(again.rejected.size(), 1U);
}

/// The slip of `exported_on_film`, whose end the person moved to 1.95 s after the first event. The press keeps its times.
ImportedLabels moved_on_film(const LabelsToExport& run) {
  ImportedLabels imported{.where = "labels.csv"};
  const ClockRelation film = run.times.to_camera(run.first_event);
  imported.intervals.reserve(run.labels.intervals.size());
  for (const LabelledInterval& old : run.labels.intervals) {
    imported.intervals.push_back({.id = old.id,
                                  .touch = old.touch,
                                  .start_us = film.clock_us_from(old.start.at),
                                  .end_us = film.clock_us_from(old.end.at),
                                  .start_rounding_us = 500,
                                  .end_rounding_us = 500,
                                  .where = "labels.csv"});
  }
  imported.intervals[2].end_us = film.clock_us_from(in_run(1'950'000));
  return imported;
}

TEST_F(WithEdits, AnEndMovedOnTheFilmIsAsUncertainAsTheFilmsClockThere) {
  run = test::exported_on_film();
  alignment::FittedClock film;
  film.relation = run.times.to_camera(run.first_event);
  film.offset_low_us = film.relation.offset_us - 8'000;
  film.offset_high_us = film.relation.offset_us + 8'000;
  film.found_at_us = film.relation.clock_us_from(in_run(950'000));  // 1 s before the moved end: 30 ms by the drift
  film.drift_within_ppm = 30'000;
  run.labels.video_clock = film;
  const Labels labels = edited(moved_on_film(run));
  EXPECT_EQ(counts.moved, 1U);
  const LabelledInterval& slip = labels.intervals[2];
  constexpr double within_us = 31'052;  // hypot(500, 8'000, 30'000)
  EXPECT_NEAR(static_cast<double>(between(slip.end.low, slip.end.at).count()), within_us, 5);
  EXPECT_NEAR(static_cast<double>(between(slip.end.at, slip.end.high).count()), within_us, 5);
  EXPECT_EQ(slip.start.low, in_run(1'483'700)) << "not moved";
}

TEST_F(WithEdits, AnEndMovedOnAFilmOfUnknownClockIsRefused) {
  run = test::exported_on_film();
  const ImportedLabels imported = moved_on_film(run);
  EXPECT_EQ(
      test::error_of([&] { edited(imported); }),
      "labels.csv: slip-1 is moved or new, in times of the film, but the run's video clock is unknown; expected times of the "
      "origin first-event or camera");
}

TEST_F(WithEdits, AnIntervalThatLostItsIdIsKnownByItsPlace) {
  ImportedLabels imported = in_milliseconds();
  for (ImportedInterval& interval : imported.intervals) interval.id.clear();
  imported.intervals[2].start_us = 1'470'000;
  const Labels labels = edited(imported);
  EXPECT_EQ(counts.kept, 2U);
  EXPECT_EQ(counts.moved, 1U);
  EXPECT_EQ(labels.intervals[0].start.at, in_run(929'637));
  EXPECT_EQ(labels.intervals[2].id, "slip-1");
}

TEST_F(WithEdits, AnotherClassIsAnEditToo) {
  ImportedLabels imported = in_milliseconds();
  imported.intervals[1].touch = Touch::slip;
  const Labels labels = edited(imported);
  EXPECT_EQ(counts.moved, 1U);
  EXPECT_EQ(labels.intervals[1].touch, Touch::slip);
  EXPECT_EQ(labels.intervals[1].start.at, in_run(1'100'499));
  EXPECT_EQ(labels.intervals[1].source, "person");
}

TEST_F(WithEdits, AMarkConfirmsAndLiftsTheIntervalsFlags) {
  run.labels.flags = {{.interval_index = 1, .reason = "look", .confirmed = false},
                      {.interval_index = 2, .reason = "look", .confirmed = false},
                      {.interval_index = {}, .reason = "whole", .confirmed = false}};
  ImportedLabels imported = in_milliseconds();
  imported.intervals[1].confirmed = true;
  imported.intervals.erase(imported.intervals.begin());
  const Labels labels = edited(imported);
  EXPECT_EQ(counts.confirmed, 1U);
  EXPECT_EQ(labels.intervals[0].id, "press-2");
  EXPECT_TRUE(labels.intervals[0].confirmed);
  EXPECT_EQ(labels.intervals[0].source, "events");
  EXPECT_FALSE(labels.interval_is_flagged(0));
  EXPECT_TRUE(labels.interval_is_flagged(1));
  EXPECT_TRUE(labels.run_is_flagged());
}

TEST_F(WithEdits, KeepsWhatIsNotAnnotated) {
  ImportedLabels imported{.where = "tasks.json", .looked_at = false};
  const Labels labels = edited(imported);
  EXPECT_EQ(labels.intervals.size(), 3U);
  EXPECT_TRUE(labels.rejected.empty());
  EXPECT_EQ(counts.edits(), 0U);
}

TEST_F(WithEdits, EndsThatMeetExceptForTheRoundingMeet) {
  ImportedLabels imported = in_milliseconds();
  imported.intervals[1].end_us = 1'485'000;  // where the slip begins, which is at 1484.4 and in the file at 1484
  const Labels labels = edited(imported);
  EXPECT_EQ(labels.intervals[1].end.at, in_run(1'484'400));
  EXPECT_EQ(labels.intervals[2].start.at, in_run(1'484'400));
}

TEST_F(WithEdits, TwoThatBeginTogetherOverlapHoweverShortTheFirstIs) {
  ImportedLabels imported = in_milliseconds();
  for (const std::int64_t end_us : {2'100'800, 2'300'000}) {
    imported.intervals.push_back({.id = "",
                                  .touch = Touch::press,
                                  .start_us = 2'100'000,
                                  .end_us = end_us,
                                  .start_rounding_us = 1000,
                                  .end_rounding_us = 1000,
                                  .where = "labels.csv"});
  }
  EXPECT_EQ(test::error_of([&] { edited(imported); }),
            "labels.csv: a new press and a new press overlap by 0.000800 s; expected intervals without overlap");
}

TEST_F(WithEdits, WhatCannotBeALabelIsNamed) {
  const auto refused = [&](const auto& change) {
    ImportedLabels imported = in_milliseconds();
    change(imported.intervals);
    return test::error_of([&] { edited(imported); });
  };
  using Intervals = std::vector<ImportedInterval>;
  EXPECT_NE(refused([](Intervals& i) { i[0].end_us = 1'150'000; }).find("press-1 and press-2 overlap by 0.049501 s"),
            std::string::npos);
  EXPECT_NE(refused([](Intervals& i) { i[0].end_us = i[0].start_us; }).find("has no length"), std::string::npos);
  EXPECT_NE(refused([](Intervals& i) { i[0].end_us = 0; }).find("expected its end after its start"), std::string::npos);
  EXPECT_NE(refused([](Intervals& i) { i[1].id = "press-1"; }).find("occurs twice"), std::string::npos);
  EXPECT_NE(
      refused([](Intervals& i) { i[2].end_us = 3'200'000; }).find("outside the recording; expected 0.000000 s to 3.000000 s"),
      std::string::npos);
  EXPECT_NE(refused([](Intervals& i) { i[0].start_us = -5'000; }).find("outside the recording"), std::string::npos);
  EXPECT_NE(refused([](Intervals& i) { i[0].start_us = std::numeric_limits<std::int64_t>::min(); }).find("outside"),
            std::string::npos);
}

TEST_F(WithEdits, ARejectionEndsWhereAPersonPutsAnIntervalBack) {
  run.labels.rejected = {{Touch::press, in_run(2'000'000), in_run(2'200'000)},
                         {Touch::slip, in_run(2'000'000), in_run(2'200'000)}};
  ImportedLabels imported = in_milliseconds();
  imported.intervals.push_back({.id = "", .touch = Touch::press, .start_us = 2'100'000, .end_us = 2'300'000, .where = "w"});
  const Labels labels = edited(imported);
  ASSERT_EQ(labels.rejected.size(), 1U);
  EXPECT_EQ(labels.rejected[0].touch, Touch::slip);
}

}  // namespace
}  // namespace tactile::labels
