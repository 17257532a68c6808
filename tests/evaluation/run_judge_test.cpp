#include "tactile/evaluation/run_judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

using Alarms = std::map<std::string, std::uint64_t>;
using test::interval_ms;
using test::ticks_of;
using test::verdict_row;

// Ticks lie at 0, 2, 4, ... ms, so tick i at 2 i ms.

Course course_with(std::vector<TouchInterval> touches, std::vector<Course::Motion> motions = {}) {
  Course course{.by_truth = true, .touches = std::move(touches), .gross = {}, .in_doubt = {}, .motions = std::move(motions)};
  course.gross.resize(course.touches.size());
  return course;
}

results::Cell judged(const std::vector<Touch>& verdicts, const Course& course) {
  return RunJudge(ticks_of(verdicts), course).judged(verdicts);
}

results::Cell judged(std::string_view letters, const Course& course) { return judged(verdict_row(letters), course); }

TEST(Episodes, AreMaximalRowsOfOneVerdictOtherThanNone) {
  using Rows = std::vector<std::tuple<Touch, std::int64_t, std::int64_t>>;
  const auto rows = [](std::string_view letters) {
    Rows found;
    for (const Episode& episode : episodes_in(verdict_row(letters)))
      found.emplace_back(episode.touch, episode.first, episode.last);
    return found;
  };
  EXPECT_EQ(rows(".pps.pp"), (Rows{{Touch::press, 1, 2}, {Touch::slip, 3, 3}, {Touch::press, 5, 6}}));
  EXPECT_EQ(rows("ssss"), (Rows{{Touch::slip, 0, 3}}));
  EXPECT_TRUE(rows("....").empty());
  EXPECT_TRUE(rows("").empty());
}

TEST(RunJudge, CountsEpisodesThatBeginInNoTouch) {
  const results::Cell cell = judged("pp.s.pp.", course_with({}));
  EXPECT_EQ(cell.alarms, (Alarms{{"quiet", 3}}));
  EXPECT_DOUBLE_EQ(cell.outside_s, 0.016);
  EXPECT_DOUBLE_EQ(cell.in_alarm_s, 0.010);
  EXPECT_EQ(judged(".ps.", course_with({})).alarm_count(), 2U) << "another class begins another episode";
}

TEST(RunJudge, TakesTheFirstTickOfATouchAfterItsOnset) {
  // Onset at 6 ms: tick 3 is not in it yet, and a slip that begins there is a false alarm.
  EXPECT_EQ(judged("...s......", course_with({interval_ms(Touch::press, 6, 20)})).alarm_count(), 1U);
  const results::Cell inside = judged("....s.....", course_with({interval_ms(Touch::press, 6, 20)}));
  EXPECT_EQ(inside.alarm_count(), 0U);
  EXPECT_EQ(inside.wrong_class, 1U);
}

TEST(RunJudge, CallsWhatBeginsInATouchOfTheOtherClassWrong) {
  // The press holds ticks 3 to 6. A verdict that outlasts it is no false alarm within 500 ms.
  const results::Cell cell = judged("...ps.ppp.", course_with({interval_ms(Touch::press, 5, 12)}));
  EXPECT_EQ(cell.alarm_count(), 0U);
  EXPECT_EQ(cell.wrong_class, 1U);
  ASSERT_EQ(cell.touches.size(), 1U);
  EXPECT_EQ(cell.touches[0].outcome, results::DetectionOutcome::detected);
}

TEST(RunJudge, HasTheDelayInTicksAndTheTimeSinceTheOnset) {
  // Onset at 5 ms; the first tick after it is tick 3, and the press is predicted from tick 5 on, at 10 ms.
  const results::Cell cell = judged(".....pp...", course_with({interval_ms(Touch::press, 5, 18)}));
  ASSERT_EQ(cell.touches.size(), 1U);
  EXPECT_DOUBLE_EQ(cell.touches[0].ms, 5);
  EXPECT_DOUBLE_EQ(cell.delay_ms(cell.touches[0]), 6);
}

TEST(RunJudge, CountsTheDelayFromGrossSlipToo) {
  Course course = course_with({interval_ms(Touch::press, 1, 4), interval_ms(Touch::slip, 7, 30)});
  course.gross[1] = camera_time(15'000);
  const results::Cell cell = judged(".p...ss........", course);
  ASSERT_EQ(cell.touches.size(), 2U);
  EXPECT_FALSE(cell.touches[0].gross_ms);
  // Detected at 10 ms, 5 ms ahead. The ticks after 15 ms begin with that at 16 ms, two after that at 12: (5 - 8 + 1) 2 ms.
  EXPECT_DOUBLE_EQ(*cell.touches[1].gross_ms, -5);
  EXPECT_DOUBLE_EQ(*cell.gross_delay_ms(cell.touches[1]), -4);
  course.gross[1] = camera_time(14'000);
  EXPECT_DOUBLE_EQ(*judged(".p...ss........", course).gross_delay_ms(cell.touches[1]), -4);
}

TEST(RunJudge, CountsNoHeadStartAndAnEarlyEpisode) {
  // Onset at 21 ms, k0 is tick 11. Ten milliseconds ahead of it is a detection.
  const Course course = course_with({interval_ms(Touch::press, 21, 26)});
  const results::Cell ahead = judged("......pppppppp", course), early = judged(".....ppppppppp", course);
  EXPECT_EQ(ahead.alarm_count(), 0U);
  EXPECT_DOUBLE_EQ(ahead.delay_ms(ahead.touches[0]), 2);
  EXPECT_EQ(early.alarm_count(), 1U);
  EXPECT_EQ(early.touches[0].outcome, results::DetectionOutcome::early);
  EXPECT_EQ(judged(".........pp.pp", course).alarm_count(), 1U) << "it ends before the onset";
}

TEST(RunJudge, CountsAnEarlyEpisodeThatBeganInAnotherTouch) {
  const std::vector<TouchInterval> slips{interval_ms(Touch::slip, 1, 6), interval_ms(Touch::slip, 25, 30)};
  EXPECT_EQ(judged(".ssssssssssssss", course_with(slips)).alarm_count(), 1U);
}

TEST(RunJudge, LeavesOutTouchesInDoubtAndTheirTime) {
  Course course = course_with({interval_ms(Touch::press, 3, 8)});
  course.in_doubt = {interval_ms(Touch::slip, 9, 14)};
  const results::Cell cell = judged("..p..pss..", course);
  EXPECT_EQ(cell.touches.size(), 1U);
  EXPECT_EQ(cell.alarm_count(), 0U);
  EXPECT_EQ(cell.wrong_class, 0U);
  EXPECT_DOUBLE_EQ(cell.outside_s, 0.002 * 2) << "ticks 8 and 9; 0 and 1 are less than 10 ms before it";
}

TEST(RunJudge, NamesTheMotionThatBeganLastAsTheCause) {
  const Course course = course_with({interval_ms(Touch::press, 100, 200)}, {{interval_ms(Touch::press, 200, 900), "relaxation"},
                                                                            {interval_ms(Touch::slip, 400, 440), "firm lift"}});
  const auto cause_at = [&](std::ptrdiff_t ms) {
    std::vector<Touch> verdicts(1000, Touch::none);
    verdicts[static_cast<std::size_t>(ms / 2)] = Touch::slip;
    return judged(verdicts, course).alarms;
  };
  EXPECT_EQ(cause_at(50), (Alarms{{"quiet", 1}}));
  EXPECT_EQ(cause_at(300), (Alarms{{"relaxation", 1}}));
  EXPECT_EQ(cause_at(402), (Alarms{{"firm lift", 1}}));
  EXPECT_EQ(cause_at(460), (Alarms{{"relaxation", 1}})) << "what goes on comes before what has ended";
  EXPECT_EQ(cause_at(950), (Alarms{{"relaxation", 1}})) << "within 100 ms after its end";
  EXPECT_EQ(cause_at(1002), (Alarms{{"quiet", 1}}));
  EXPECT_EQ(judged(std::vector<Touch>(700, Touch::none), course).alarms, Alarms{});
}

TEST(RunJudge, CallsWhatComesJustAfterATouchAfterAnEnd) {
  std::vector<Touch> verdicts(500, Touch::none);
  verdicts[150] = Touch::press;  // at 300 ms
  EXPECT_EQ(judged(verdicts, course_with({interval_ms(Touch::press, 100, 240)})).alarms, (Alarms{{"after an end", 1}}));
  EXPECT_EQ(judged(verdicts, course_with({interval_ms(Touch::press, 100, 190)})).alarms, (Alarms{{"quiet", 1}}));
}

TEST(RunJudge, CountsSlipInALiftWithoutSlip) {
  Course course = course_with({interval_ms(Touch::press, 100, 200)});
  const auto slips = [&](std::ptrdiff_t ms, Touch touch = Touch::slip) {
    std::vector<Touch> verdicts(800, Touch::none);
    verdicts[static_cast<std::size_t>(ms / 2)] = touch;
    return judged(verdicts, course).false_slips;
  };
  EXPECT_EQ(slips(402), std::nullopt) << "no lift is known";
  course.lift_without_slip = camera_time(400'000);
  EXPECT_EQ(slips(402), 1U);
  EXPECT_EQ(slips(400), 0U);
  EXPECT_EQ(slips(900), 1U);
  EXPECT_EQ(slips(902), 0U);
  EXPECT_EQ(slips(402, Touch::press), 0U);
}

TEST(RunJudge, CountsAtBothEndsOfTheClock) {
  constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min(), highest = std::numeric_limits<std::int64_t>::max();
  const auto verdicts = verdict_row("p..ss.p");
  for (const std::int64_t first : {lowest, highest - 12'000}) {
    const TickRange ticks{camera_time(first), 7, 2ms};
    // The slip lies where it is predicted.
    const Course course = course_with({{Touch::slip, camera_time(first + 5'000), camera_time(first + 9'000)}});
    const results::Cell cell = RunJudge(ticks, course).judged(verdicts);
    EXPECT_EQ(cell.alarms, (Alarms{{"after an end", 1}, {"quiet", 1}})) << first;
    EXPECT_DOUBLE_EQ(cell.outside_s, 0.010) << first;
  }
}

/// 20 s: a press from 2 to 3 s, a slip from 4 to 6 s; 17 s outside of both.
struct LongRun {
  static constexpr std::size_t ticks = 10'000;
  Course course = course_with({interval_ms(Touch::press, 2000, 3000), interval_ms(Touch::slip, 4000, 6000)});

  /// One class from tick to tick, in milliseconds; else none.
  static std::vector<Touch> only(Touch touch, const std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>>& stretches_ms) {
    std::vector<Touch> verdicts(ticks, Touch::none);
    for (const auto& [from, to] : stretches_ms) std::fill(verdicts.begin() + from / 2, verdicts.begin() + to / 2, touch);
    return verdicts;
  }
};

TEST(RunJudge, CountsADetectorThatIsStuckOnOneClassAgainAndAgain) {
  for (const Touch stuck : {Touch::press, Touch::slip}) {
    const results::Cell cell = judged(std::vector<Touch>(LongRun::ticks, stuck), LongRun().course);
    EXPECT_DOUBLE_EQ(cell.outside_s, 17);
    EXPECT_DOUBLE_EQ(cell.in_alarm_s, 17);
    EXPECT_EQ(cell.alarm_count(), 34U) << "two a second";
    for (const results::TouchOutcome& touch : cell.touches)
      EXPECT_EQ(touch.outcome, touch.touch == stuck ? results::DetectionOutcome::early : results::DetectionOutcome::missed);
  }
}

TEST(RunJudge, CountsAnEpisodeAgainForEachFurtherHalfSecond) {
  const auto count = [](std::ptrdiff_t held_ms) {
    return judged(LongRun::only(Touch::press, {{10'000, 10'000 + held_ms}}), LongRun().course).alarm_count();
  };
  EXPECT_EQ(count(498), 1U);
  EXPECT_EQ(count(500), 1U);
  EXPECT_EQ(count(502), 2U);
  EXPECT_EQ(count(1'000), 2U);
  EXPECT_EQ(count(1'002), 3U);
  // From the onset of the press, which ends with the tick at 3000 ms.
  EXPECT_EQ(judged(LongRun::only(Touch::press, {{2'002, 3'490}}), LongRun().course).alarm_count(), 0U);
  EXPECT_EQ(judged(LongRun::only(Touch::press, {{2'002, 3'990}}), LongRun().course).alarms, (Alarms{{"after an end", 1}}));
}

TEST(RunJudge, FindsNothingInAPerfectDetector) {
  std::vector<Touch> verdicts(LongRun::ticks, Touch::none);
  const LongRun run;
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    verdicts[i] = touch_at(ticks_of(verdicts).at(static_cast<std::int64_t>(i)), run.course.touches);
  const results::Cell cell = judged(verdicts, run.course);
  EXPECT_EQ(cell.alarms, Alarms{});
  EXPECT_EQ(cell.wrong_class, 0U);
  EXPECT_DOUBLE_EQ(cell.in_alarm_s, 0);
  for (const results::TouchOutcome& touch : cell.touches) EXPECT_DOUBLE_EQ(cell.delay_ms(touch), 2);
}

TEST(RunJudge, NeedsOneVerdictForEachTick) {
  const auto verdicts = verdict_row("...");
  TickRange ticks = ticks_of(verdicts);
  ticks.count = 2;
  EXPECT_THROW(RunJudge(ticks, course_with({})).judged(verdicts), Error);
}

TEST(Course, IsByTheTruthOfASimulatedRun) {
  RunTruth truth;
  truth.labels = {{interval_ms(Touch::press, 100, 200), false}, {interval_ms(Touch::slip, 400, 600), true}};
  truth.releases = {interval_ms(Touch::none, 700, 800)};
  const Course by_labels = course_of(truth);
  EXPECT_FALSE(by_labels.by_truth);
  EXPECT_EQ(by_labels.touches.size(), 1U);
  EXPECT_EQ(by_labels.in_doubt.size(), 1U);
  ASSERT_EQ(by_labels.motions.size(), 1U);
  EXPECT_EQ(by_labels.motions[0].cause, "release");
  truth.has_truth = true;
  truth.true_ones = {interval_ms(Touch::press, 101, 199)};
  truth.gross = {std::nullopt};
  truth.unlabelled = {interval_ms(Touch::slip, 401, 441)};
  truth.causes = {"firm lift"};
  truth.lift = camera_time(400'000);
  const Course by_truth = course_of(truth);
  EXPECT_TRUE(by_truth.by_truth);
  EXPECT_EQ(by_truth.touches.size(), 1U);
  EXPECT_TRUE(by_truth.in_doubt.empty());
  EXPECT_EQ(by_truth.motions.at(0).cause, "firm lift");
  EXPECT_EQ(by_truth.lift_without_slip, camera_time(400'000));
  truth.true_ones.push_back(interval_ms(Touch::slip, 401, 600));
  truth.gross.emplace_back();
  EXPECT_FALSE(course_of(truth).lift_without_slip) << "it slips";
}

/// Probabilities of a run of 600 ms: log-odds of 1.2, 5.2 and 9.2 for one class, each at one tick.
std::vector<model::Probabilities> three_peaks(Touch touch) {
  std::vector<model::Probabilities> probabilities(300, {1, 0, 0});
  for (const auto& [tick, odds] : {std::pair(50U, 1.2), std::pair(150U, 5.2), std::pair(250U, 9.2)}) {
    const double p = 1 / (1 + std::exp(-odds));
    probabilities[tick][0] = static_cast<float>(1 - p);
    probabilities[tick][static_cast<std::size_t>(touch)] = static_cast<float>(p);
  }
  return probabilities;
}

TEST(JudgedAlongCurve, HasFewerAlarmsAtHigherThresholds) {
  const auto probabilities = three_peaks(Touch::press);
  const std::vector<Touch> verdicts(300, Touch::none);
  const auto cells = judged_along_curve(RunJudge(ticks_of(verdicts), course_with({})), 2ms, verdicts, probabilities);
  EXPECT_FALSE(cells[0].threshold);
  EXPECT_EQ(cells[0].alarm_count(), 0U);
  for (const results::Cell& cell : cells) {
    if (!cell.threshold) continue;
    if (cell.confirmed) {
      EXPECT_EQ(cell.alarm_count(), 0U) << "no slip at all";
      continue;
    }
    EXPECT_EQ(cell.alarm_count(),
              static_cast<unsigned>((*cell.threshold < 1.2) + (*cell.threshold < 5.2) + (*cell.threshold < 9.2)))
        << *cell.threshold;
  }
}

TEST(RunJudge, CountsTheRightTicksEarlyAndLateInATouch) {
  // A press from 1 to 700 ms: ticks 1 to 350. Right until 400 ms, tick 200.
  std::vector<Touch> verdicts(400, Touch::none);
  for (std::size_t i = 1; i <= 200; ++i) verdicts[i] = Touch::press;
  const results::Cell cell = judged(verdicts, course_with({interval_ms(Touch::press, 1, 700)}));
  EXPECT_EQ(cell.first, (results::TickCount{250, 200})) << "ticks 1 to 250";
  EXPECT_EQ(cell.before_last, (results::TickCount{250, 200})) << "ticks 1 to 250, up to 500 ms";
  EXPECT_EQ(cell.last, (results::TickCount{100, 0}));
  const results::Cell brief = judged(verdicts, course_with({interval_ms(Touch::press, 1, 200)}));
  EXPECT_EQ(brief.first, (results::TickCount{100, 100}));
  EXPECT_EQ(brief.last.ticks + brief.before_last.ticks, 0U) << "it has nothing before its last 200 ms";
}

TEST(RunJudge, CountsASlipThatStandsWhenTheLiftBegins) {
  Course course = course_with({});
  course.lift_without_slip = camera_time(10'000);
  EXPECT_EQ(judged("..sssss...", course).false_slips, 1U) << "it lasts into the lift";
  EXPECT_EQ(judged("..ssss....", course).false_slips, 0U) << "its last tick is the lift's own time";
  EXPECT_EQ(judged("..ppppp.s.", course).false_slips, 1U);
}

TEST(JudgedAlongCurve, HasConfirmedSlipsAlone) {
  // A press that nobody finds, and the peak of 9.2 at 500 ms in a slip since 491 ms.
  const auto probabilities = three_peaks(Touch::slip);
  const std::vector<Touch> verdicts(300, Touch::none);
  const RunJudge judge(ticks_of(verdicts), course_with({interval_ms(Touch::press, 3, 20), interval_ms(Touch::slip, 491, 590)}));
  const model::TwoThresholds thresholds{.on = 1.4, .off = -2.6};
  std::size_t confirmed = 0;
  for (const results::Cell& cell : judged_along_curve(judge, 2ms, verdicts, probabilities, thresholds)) {
    if (!cell.confirmed) continue;
    ++confirmed;
    const double from = cell.threshold.value_or(3.5);
    ASSERT_EQ(cell.touches.size(), 1U) << "slips alone";
    EXPECT_EQ(cell.touches[0].outcome == results::DetectionOutcome::detected, from < 9.2) << from;
    EXPECT_EQ(cell.alarm_count(), from < 5.2 ? 1U : 0U) << from << ": the peak of 1.2 is below ON";
  }
  EXPECT_EQ(confirmed, 1 + 30U) << "as decided, and from 1.5 to 16";
}

}  // namespace
}  // namespace tactile::evaluation
