#include "tactile/evaluation/false_alarms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

using test::interval_ms;
using test::ticks_of;
using test::verdict_row;

results::FalseAlarms alarms_in(std::string_view letters, std::vector<TouchInterval> intervals, microseconds guard = 4ms,
                               std::vector<TouchInterval> unlabelled = {}, std::vector<TouchInterval> releases = {}) {
  const auto verdicts = verdict_row(letters);
  const auto detections = detections_of(ticks_of(verdicts), verdicts, intervals);
  return false_alarms_of(ticks_of(verdicts), verdicts, {intervals, releases, unlabelled, guard}, detections);
}

// Ticks lie at 0, 2, 4, ... ms, so tick i at 2 i ms.

TEST(FalseAlarms, AreEpisodesThatBeginInNoInterval) {
  const results::FalseAlarms found = alarms_in("pp.s.pp.", {});
  EXPECT_EQ(found.alarms, 3U);
  EXPECT_EQ(found.none_time, 16ms);
}

TEST(FalseAlarms, ChangingTheClassBeginsAnotherEpisode) { EXPECT_EQ(alarms_in(".ps.", {}).alarms, 2U); }

TEST(FalseAlarms, AnEpisodeThatBeginsInAnIntervalIsNoFalseAlarmOfAnyClass) {
  // The interval holds ticks 3 to 6 (6 to 12 ms); a slip predicted in a press is wrong, but no false alarm, nor is what outlasts
  // the interval.
  EXPECT_EQ(alarms_in("...ps.ppp.", {interval_ms(Touch::press, 5, 12)}).alarms, 0U);
}

TEST(FalseAlarms, TheFirstTickOfAnIntervalLiesAfterItsStart) {
  // Start at 6 ms: tick 3 is not in it yet, and a slip that begins there is a false alarm.
  EXPECT_EQ(alarms_in("...s......", {interval_ms(Touch::press, 6, 20)}).alarms, 1U);
  EXPECT_EQ(alarms_in("....s.....", {interval_ms(Touch::press, 6, 20)}).alarms, 0U);
}

TEST(FalseAlarms, WithinTheGuardAfterAnIntervalAreCountedApart) {
  // Ends at 8 ms (tick 4); the guard of 4 ms holds ticks 5 and 6.
  const std::vector<TouchInterval> intervals{interval_ms(Touch::press, 3, 8)};
  const results::FalseAlarms within = alarms_in("......s...", intervals);
  EXPECT_EQ(within.alarms, 0U);
  EXPECT_EQ(within.after_intervals, 1U);
  EXPECT_EQ(within.after_intervals_time, 4ms);
  EXPECT_EQ(within.none_time, 2ms * (10 - 3 - 2));  // without ticks 2, 3, 4 of the interval and the two of the guard
  EXPECT_EQ(alarms_in(".......s..", intervals).alarms, 1U);
}

TEST(FalseAlarms, InUnlabelledMotionAreCountedApart) {
  const results::FalseAlarms found = alarms_in("..s..s....", {}, 4ms, {interval_ms(Touch::slip, 3, 6)});
  EXPECT_EQ(found.alarms, 1U);
  EXPECT_EQ(found.unlabelled, 1U);
  EXPECT_EQ(found.unlabelled_time, 4ms);
  EXPECT_EQ(found.none_time, 16ms);
}

TEST(FalseAlarms, InAReleaseAndWithinTheGuardAfterItAreCountedApart) {
  const results::FalseAlarms found =
      alarms_in("..s..s.s.s", {}, 4ms, {}, {{Touch::none, camera_time(3'000), camera_time(6'000)}});
  EXPECT_EQ(found.alarms, 2U) << "at 14 and 18 ms";
  EXPECT_EQ(found.releases, 2U);
  EXPECT_EQ(found.releases_time, 8ms) << "ticks at 4, 6, 8 and 10 ms";
  EXPECT_EQ(found.none_time, 12ms);
}

TEST(FalseAlarms, TheEpisodeThatDetectsAnOnsetTenMillisecondsAheadIsNone) {
  // Onset at 21 ms, k0 is tick 11.
  EXPECT_EQ(alarms_in("......pppppppp", {interval_ms(Touch::press, 21, 26)}).alarms, 0U);
}

TEST(FalseAlarms, TheEpisodeThatMakesAnIntervalEarlyIsOne) {
  EXPECT_EQ(alarms_in(".....ppppppppp", {interval_ms(Touch::press, 21, 26)}).alarms, 1U);
}

TEST(FalseAlarms, AnEpisodeThatEndsJustBeforeTheOnsetIsOne) {
  EXPECT_EQ(alarms_in(".........pp.pp", {interval_ms(Touch::press, 21, 26)}).alarms, 1U);
}

TEST(FalseAlarms, AnEarlyEpisodeThatBeganInAnotherIntervalIsOneToo) {
  // Slip is predicted from within the first slip until the second, 20 ms later.
  const std::vector<TouchInterval> slips{interval_ms(Touch::slip, 1, 6), interval_ms(Touch::slip, 25, 30)};
  EXPECT_EQ(alarms_in(".ssssssssssssss", slips).alarms, 1U);
}

TEST(FalseAlarms, AreCountedAtBothEndsOfTheClock) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  const auto verdicts = verdict_row("p..ss.p");
  for (const std::int64_t first : {lowest, highest - 12'000}) {
    const TickRange ticks{camera_time(first), 7, 2ms};
    // The slip lies where it is predicted; the guard after the last press ends with the clock.
    const std::vector<TouchInterval> intervals{{Touch::slip, camera_time(first + 5'000), camera_time(first + 9'000)}};
    const results::FalseAlarms found =
        false_alarms_of(ticks, verdicts, {intervals, {}, {}, microseconds::max()}, detections_of(ticks, verdicts, intervals));
    EXPECT_EQ(found.alarms, 1U) << first;
    EXPECT_EQ(found.after_intervals, 1U) << first;
    EXPECT_EQ(found.none_time, 6ms) << first;
    EXPECT_EQ(found.after_intervals_time, 4ms) << first;
  }
}

/// 20 s: a press from 2 to 3 s, a slip from 4 to 6 s; 17 s outside of both, 3 s in them.
struct LongRun {
  static constexpr std::size_t ticks = 10'000;
  std::vector<TouchInterval> intervals{interval_ms(Touch::press, 2000, 3000), interval_ms(Touch::slip, 4000, 6000)};

  results::FalseAlarms alarms_of(const std::vector<Touch>& verdicts, std::vector<TouchInterval> unlabelled = {},
                                 std::vector<TouchInterval> releases = {}) const {
    const auto detections = detections_of(ticks_of(verdicts), verdicts, intervals);
    return false_alarms_of(ticks_of(verdicts), verdicts, {intervals, releases, unlabelled, 100ms}, detections);
  }
  /// One class from tick to tick, in milliseconds; else none.
  static std::vector<Touch> only(Touch touch, const std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>>& stretches_ms) {
    std::vector<Touch> verdicts(ticks, Touch::none);
    for (const auto& [from, to] : stretches_ms) std::fill(verdicts.begin() + from / 2, verdicts.begin() + to / 2, touch);
    return verdicts;
  }
};

TEST(FalseAlarmForms, OfADetectorStuckOnOneClassAreManyInAll) {
  for (const Touch stuck : {Touch::press, Touch::slip}) {
    const results::FalseAlarms found = LongRun().alarms_of(std::vector<Touch>(LongRun::ticks, stuck));
    EXPECT_EQ(found.outside_labels_time, 17s);
    EXPECT_EQ(found.outside_labels, 34U) << "2 a second";
    EXPECT_EQ(*found.outside_labels_per_min(), 120);
    EXPECT_EQ(*found.outside_motion_per_min(), 120);
    EXPECT_EQ(*found.none_in_alarm_share(), 1);
    EXPECT_EQ(*found.outside_labels_share(), 1);
    EXPECT_EQ(*found.outside_motion_share(), 1);
    EXPECT_DOUBLE_EQ(*found.wrong_class_share(), stuck == Touch::press ? 2.0 / 3 : 1.0 / 3);
    // Press in the slip of 2 s: four times. Slip in the press of 1 s: twice.
    EXPECT_EQ(found.wrong_class, stuck == Touch::press ? 4U : 2U);
    EXPECT_EQ(found.labelled_time, 3s);
    EXPECT_EQ(found.alarms, 1U) << "the count of episodes alone calls it quiet";
  }
}

TEST(FalseAlarmForms, DistinguishANervousDetectorFromAStuckOneByTheirTime) {
  std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>> flickers;
  for (std::size_t ms = 0; ms < 2 * LongRun::ticks; ms += 500) flickers.emplace_back(ms, ms + 10);
  const results::FalseAlarms nervous = LongRun().alarms_of(LongRun::only(Touch::slip, flickers));
  EXPECT_NEAR(*nervous.outside_labels_per_min(), 120, 10) << "as many as of a stuck one";
  EXPECT_NEAR(*nervous.outside_labels_share(), 0.02, 0.002);
  EXPECT_LT(*nervous.outside_motion_share(), 0.03);
  EXPECT_LT(*nervous.wrong_class_share(), 0.03);
}

TEST(FalseAlarmForms, OfAPerfectDetectorAreNone) {
  std::vector<Touch> verdicts(LongRun::ticks, Touch::none);
  for (const TouchInterval& interval : LongRun().intervals) {
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      if (interval.contains(ticks_of(verdicts).at(static_cast<std::int64_t>(i)))) verdicts[i] = interval.touch;
    }
  }
  const results::FalseAlarms found = LongRun().alarms_of(verdicts);
  EXPECT_EQ(found.outside_labels, 0U);
  EXPECT_EQ(found.outside_motion, 0U);
  EXPECT_EQ(found.none_in_alarm, 0us);
  EXPECT_EQ(found.wrong_class, 0U);
  EXPECT_EQ(found.wrong_class_time, 0us);
}

TEST(FalseAlarmForms, OfOneFlickerAreOneAndItsTime) {
  const results::FalseAlarms found = LongRun().alarms_of(LongRun::only(Touch::slip, {{10'000, 10'004}}));
  EXPECT_EQ(found.outside_labels, 1U);
  EXPECT_DOUBLE_EQ(*found.outside_labels_per_min(), 60.0 / 17);
  EXPECT_EQ(found.none_in_alarm, 4ms);
  EXPECT_EQ(found.wrong_class, 0U);
}

TEST(FalseAlarmForms, CountAnEpisodeAgainForEachFurtherHalfSecond) {
  const auto count = [](std::ptrdiff_t held_ms) {
    return LongRun().alarms_of(LongRun::only(Touch::press, {{10'000, 10'000 + held_ms}})).outside_labels;
  };
  EXPECT_EQ(count(498), 1U);
  EXPECT_EQ(count(500), 1U);
  EXPECT_EQ(count(502), 2U);
  EXPECT_EQ(count(1'000), 2U);
  EXPECT_EQ(count(1'002), 3U);
}

TEST(FalseAlarmForms, TakeAVerdictThatOutlastsItsIntervalAsOneOnlyAfterHalfASecond) {
  // Press from its onset on; the interval ends with the tick at 3000 ms.
  EXPECT_EQ(LongRun().alarms_of(LongRun::only(Touch::press, {{2'002, 3'490}})).outside_labels, 0U);
  EXPECT_EQ(LongRun().alarms_of(LongRun::only(Touch::press, {{2'002, 3'990}})).outside_labels, 1U);
}

TEST(FalseAlarmForms, OutsideLabelsHaveWhatIsLeftOutOfNone) {
  // Just after the press, in a release, in unlabelled motion, and in none: all four are what a laboratory sees.
  const results::FalseAlarms found =
      LongRun().alarms_of(LongRun::only(Touch::slip, {{3'050, 3'060}, {8'500, 8'510}, {12'500, 12'510}, {15'000, 15'010}}),
                          {interval_ms(Touch::slip, 12'000, 13'000)}, {interval_ms(Touch::none, 8'000, 9'000)});
  EXPECT_EQ(found.alarms, 1U);
  EXPECT_EQ(found.outside_labels, 4U);
  EXPECT_EQ(found.outside_labels_time, 17s);
  EXPECT_EQ(found.outside_motion, 3U) << "without the one in unlabelled motion";
  EXPECT_EQ(found.outside_motion_time, 16s);
  EXPECT_EQ(found.none_in_alarm, 10ms);
}

TEST(FalseAlarmForms, HaveNothingOutsideOfMotionThatIsNotKnown) {
  const LongRun run;
  const std::vector<Touch> verdicts = LongRun::only(Touch::slip, {{1'000, 3'500}, {15'000, 15'010}});
  const TickRange ticks = ticks_of(verdicts);
  const results::FalseAlarms found =
      false_alarms_of(ticks, verdicts, {run.intervals, {}, {}, 100ms, false}, detections_of(ticks, verdicts, run.intervals));
  EXPECT_GT(found.outside_labels, 1U);
  EXPECT_EQ(found.outside_motion, 0U);
  EXPECT_EQ(found.outside_motion_time, 0s);
  EXPECT_EQ(found.outside_motion_per_min(), std::nullopt);
  EXPECT_EQ(found.outside_motion_share(), std::nullopt);
}

TEST(FalseAlarmForms, CountSlipPredictedInsideAPress) {
  const results::FalseAlarms found = LongRun().alarms_of(LongRun::only(Touch::slip, {{2'500, 2'568}}));
  EXPECT_EQ(found.alarms, 0U);
  EXPECT_EQ(found.outside_labels, 0U);
  EXPECT_EQ(found.wrong_class, 1U);
  EXPECT_EQ(found.wrong_class_time, 68ms);
  EXPECT_DOUBLE_EQ(*found.wrong_class_per_min(), 20);
}

TEST(FalseAlarmForms, AllowTheGuardToAnotherClassThatBeganBeforeTheInterval) {
  // The interval holds the ticks after 2000 ms.
  EXPECT_EQ(LongRun().alarms_of(LongRun::only(Touch::slip, {{1'900, 2'102}})).wrong_class, 0U) << "100 ms in it";
  EXPECT_EQ(LongRun().alarms_of(LongRun::only(Touch::slip, {{1'900, 2'104}})).wrong_class, 1U) << "102 ms";
  EXPECT_EQ(LongRun().alarms_of(LongRun::only(Touch::slip, {{2'002, 2'004}})).wrong_class, 1U) << "begun in it";
}

TEST(FalseAlarms, NeedOneVerdictForEachTick) {
  const auto verdicts = verdict_row("...");
  TickRange ticks = ticks_of(verdicts);
  ticks.count = 2;
  EXPECT_THROW(false_alarms_of(ticks, verdicts, {{}, {}, {}, 4ms}, {}), Error);
}

/// Of each object `runs` runs of `none_time` with `alarms` each.
std::vector<RunFalseAlarms> alike(std::initializer_list<const char*> objects, std::size_t runs, std::uint64_t alarms,
                                  microseconds none_time) {
  results::FalseAlarms counts;
  counts.alarms = alarms;
  counts.none_time = none_time;
  std::vector<RunFalseAlarms> made;
  for (const char* object : objects) made.insert(made.end(), runs, RunFalseAlarms{{object}, counts});
  return made;
}

TEST(FalseAlarmTable, HasAnIntervalAboveZeroWithoutAnAlarm) {
  // Four runs of 5 s; Garwood's bound for none met is 3.68888, over a third of a minute.
  const results::Figure per_min = false_alarm_table(alike({"fan", "box", "hub", "bottle"}, 1, 0, 5s)).per_min;
  EXPECT_EQ(per_min.value, 0);
  ASSERT_TRUE(per_min.low && per_min.high);
  EXPECT_EQ(*per_min.low, 0);
  EXPECT_NEAR(*per_min.high, 3 * 3.688879, 1e-4);
}

TEST(FalseAlarmTable, EndsNoIntervalBelowWhatAFewAlarmsMayMean) {
  // Every run of an object alike: runs alone say nothing of their spread.
  const results::FalseAlarmTable table = false_alarm_table(alike({"fan", "box", "hub"}, 4, 1, 10s));
  EXPECT_DOUBLE_EQ(table.per_min.value, 6);
  ASSERT_TRUE(table.per_min.high && table.objects.at("fan").high);
  EXPECT_NEAR(*table.per_min.high, 20.961585 / 2, 1e-4) << "12 in two minutes";
  EXPECT_NEAR(*table.objects.at("fan").high, 10.241589 * 60 / 40, 1e-4) << "4 in 40 s";
}

TEST(FalseAlarmTable, LeavesTheIntervalOfManyAlarmsToTheSpreadOfObjects) {
  auto runs = alike({"fan"}, 3, 2000, 60s);
  const auto quiet = alike({"box", "hub"}, 3, 1000, 60s);
  runs.insert(runs.end(), quiet.begin(), quiet.end());
  const results::Figure per_min = false_alarm_table(runs).per_min;
  EXPECT_DOUBLE_EQ(per_min.value, 12'000.0 / 9);
  ASSERT_TRUE(per_min.high);
  EXPECT_GT(*per_min.high, 2000) << "three objects of 1000 to 2000; the count alone leaves 1357 at most";
}

TEST(FalseAlarmTable, KeepsTheIntervalOfAShareBetweenNothingAndAll) {
  std::vector<RunFalseAlarms> runs = alike({"fan", "box", "hub"}, 1, 0, 10s);
  runs[0].counts.none_in_alarm = 1s;
  runs[1].counts.none_in_alarm = 2s;
  runs[2].counts.none_in_alarm = 3s;
  const results::Figure share = false_alarm_table(runs).none_in_alarm_share;
  EXPECT_DOUBLE_EQ(share.value, 0.2);
  ASSERT_TRUE(share.has_interval());
  // Without limits it would be 0.2 -+ 0.36: the jackknife's deviation is 0.058, and t of two degrees of freedom is 6.2.
  EXPECT_GT(*share.low, 0);
  EXPECT_LT(*share.low, 0.1);
  EXPECT_GT(*share.high, 0.5);
  EXPECT_LT(*share.high, 1);
}

TEST(FalseAlarmTable, HasNoMoreThanAnAlarmInEachTick) {
  // One object has all alarms: without a limit, the interval would end at several hundred thousand a minute.
  auto runs = alike({"fan", "box", "hub"}, 1, 0, 60s);
  runs[0].counts.alarms = 10'000;
  for (RunFalseAlarms& run : runs) run.counts.tick = 2ms;
  const results::Figure per_min = false_alarm_table(runs).per_min;
  ASSERT_TRUE(per_min.has_interval());
  EXPECT_GT(*per_min.high, 10'000);
  EXPECT_LE(*per_min.high, 30'000);
}

TEST(FalseAlarmTable, HasNoIntervalOfTwoRuns) {
  const results::FalseAlarmTable table = false_alarm_table(alike({"fan"}, 2, 0, 5s));
  EXPECT_FALSE(table.per_min.high || table.objects.at("fan").high);
}

TEST(WidenByFewAlarms, TakesTheAlarmsAndTheTimeOfOneSeed) {
  results::FalseAlarms counted;
  counted.alarms = 3;  // of two seeds: 2 of one, rounded up
  counted.none_time = 120s;
  results::Figure per_min{.value = 1.5, .low = 1, .high = 2, .n = 3};
  widen_by_few_alarms(per_min, counted, 0.95, 2);
  EXPECT_NEAR(*per_min.high, 7.224688, 1e-5) << "2 in a minute";
  EXPECT_EQ(*per_min.low, 1);
  results::Figure wide{.value = 1.5, .low = 1, .high = 8, .n = 3};
  widen_by_few_alarms(wide, counted, 0.95, 2);
  EXPECT_EQ(*wide.high, 8);
}

TEST(FalseAlarmTable, DividesAllAlarmsByAllNoneTime) {
  results::FalseAlarms busy, quiet;
  busy.alarms = 3;
  busy.none_time = 30s;
  quiet.none_time = 90s;
  quiet.after_intervals = 2;
  quiet.after_intervals_time = 6s;
  const std::vector<RunFalseAlarms> runs{{{"fan"}, busy}, {{"fan"}, quiet}, {{"box"}, quiet}};
  const results::FalseAlarmTable table = false_alarm_table(runs);
  EXPECT_DOUBLE_EQ(table.per_min.value, 3 / 3.5);
  EXPECT_EQ(table.per_min.n, 2U);
  EXPECT_DOUBLE_EQ(table.objects.at("fan").value, 1.5);
  EXPECT_DOUBLE_EQ(table.objects.at("box").value, 0.0);
  const nlohmann::json json = table;
  EXPECT_EQ(json.at("count"), 3);
  EXPECT_DOUBLE_EQ(json.at("none_min").get<double>(), 3.5);
  EXPECT_EQ(json.at("after_intervals").at("count"), 4);
  EXPECT_DOUBLE_EQ(json.at("after_intervals").at("min").get<double>(), 0.2);
}

}  // namespace
}  // namespace tactile::evaluation
