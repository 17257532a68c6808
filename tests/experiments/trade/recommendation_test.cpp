#include "tactile/experiments/trade/recommendation.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

results::Figure figure(double value, double half_width, std::size_t n = 10) {
  results::Figure made;
  made.value = value, made.low = value - half_width, made.high = value + half_width, made.n = n;
  return made;
}

results::TradeResult figures(double accuracy, double us, double alarms = 1, double delay_ms = 5) {
  results::TradeResult made{
      .accuracy = figure(accuracy, 0.01), .us_p50 = figure(us / 2, 5), .us_p99 = figure(us, 10), .us_p999 = figure(2 * us, 20)};
  made.whole_runs.median_ms.ms = figure(delay_ms, 0.5);
  made.whole_runs.p90_ms.ms = figure(10 * delay_ms, 5);
  made.whole_runs.missed = figure(0.1, 0.02);
  made.whole_runs.alarms_per_min = figure(alarms, 0.2);
  return made;
}

/// The same on a busy machine.
results::TradeResult disturbed(results::TradeResult figures) {
  figures.us_p50 = figure(150, 5);
  figures.interrupted = 0.14;
  return figures;
}

TEST(Choose, TakesTheMostAccurateThatIsFastEnoughInItsInterval) {
  const std::vector<results::TradeResult> settings{figures(0.99, 400), figures(0.95, 150), figures(0.97, 195),
                                                   figures(0.94, 100)};
  const auto choice = choose({.at_most_us = 200}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U) << "the interval of the third ends at 205";
  EXPECT_TRUE(choice->in_interval);
}

TEST(Choose, TakesTheFastestThatIsAccurateEnough) {
  const std::vector<results::TradeResult> settings{figures(0.99, 400), figures(0.97, 150), figures(0.90, 50)};
  const auto choice = choose({.at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U);
}

TEST(Choose, UsesValuesOnlyWhereNoIntervalMeetsTheConstraint) {
  const std::vector<results::TradeResult> settings{figures(0.955, 400), figures(0.90, 50)};
  const auto choice = choose({.at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 0U);
  EXPECT_FALSE(choice->in_interval);
}

TEST(Choose, TakesTheSurestWhereNoIntervalMeetsTheConstraint) {
  // The first is the most accurate and on the verge of both limits; the second is in the middle of what may be.
  const std::vector<results::TradeResult> settings{figures(0.959, 199), figures(0.957, 195), figures(0.951, 100)};
  const auto choice = choose({.at_most_us = 200, .at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U) << "0.5 of its half interval from the limit of time, the first 0.1, the third 0.1 from the other";
  EXPECT_FALSE(choice->in_interval);
}

TEST(Choose, FindsNothingWhereNothingMeetsEveryConstraint) {
  const std::vector<results::TradeResult> settings{figures(0.99, 400, 0.1), figures(0.90, 50, 0.1), figures(0.99, 50, 9)};
  EXPECT_FALSE(choose({.at_most_us = 200, .at_least_accuracy = 0.95, .at_most_false_alarms_per_min = 1}, settings));
  results::TradeResult unknown = figures(0.99, 50);
  unknown.accuracy = {};
  EXPECT_FALSE(choose({.at_most_us = 200}, std::vector<results::TradeResult>{unknown}));
}

TEST(Choose, LeavesOutWhatDoesNotKeepUpWithItsTicks) {
  std::vector<results::TradeResult> settings{figures(0.99, 620), figures(0.9, 150)};
  for (results::TradeResult& one : settings) one.tick_us = 500;
  const auto choice = choose({.at_most_us = 1000}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U);
  EXPECT_FALSE(recommend({.at_most_us = 1000}, "tick 0.5 ms", settings[0], {}, false).met);
}

TEST(MeetsInInterval, IsNeverSoWithoutAnInterval) {
  results::TradeResult two_runs = figures(0.99, 100);
  two_runs.accuracy.low = two_runs.accuracy.high = std::nullopt;
  const TradeConstraints constraint{.at_least_accuracy = 0.9};
  EXPECT_TRUE(meets(constraint, two_runs));
  EXPECT_FALSE(meets_in_interval(constraint, two_runs));
  EXPECT_TRUE(meets_in_interval({.at_most_us = 200}, two_runs)) << "no constraint on the accuracy";
}

TEST(Choose, UsesTheDelayOfTheConstraint) {
  std::vector<results::TradeResult> settings{figures(0.99, 100, 1, 9), figures(0.95, 100, 1, 5)};
  settings[1].whole_runs.p90_ms.ms = figure(200, 1);
  const auto of_half = choose({.at_most_delay = DelayLimit{6}}, settings);
  ASSERT_TRUE(of_half);
  EXPECT_EQ(of_half->index, 1U) << "9 ms in half of the presses and slips is too late";
  EXPECT_TRUE(of_half->in_interval);
  const auto of_90 = choose({.at_most_delay = DelayLimit{100, true}}, settings);
  ASSERT_TRUE(of_90);
  EXPECT_EQ(of_90->index, 0U) << "200 ms in 90 % of them is too late";
}

TEST(Choose, CountsMissedPressesAndSlips) {
  std::vector<results::TradeResult> settings{figures(0.99, 100), figures(0.95, 100)};
  settings[1].whole_runs.missed = figure(0.03, 0.01);
  const auto choice = choose({.at_most_missed = 0.05}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U);
  EXPECT_FALSE(choose({.at_most_missed = 0.01}, settings));
}

TEST(TextOfConstraints, NamesEachOfThem) {
  EXPECT_EQ(text_of(TradeConstraints{.at_most_delay = DelayLimit{30}, .at_most_missed = 0.05}),
            "a delay of at most 30 ms in half of the presses and slips and at most 5 % of presses and slips missed or early");
  EXPECT_EQ(text_of(TradeConstraints{.at_most_delay = DelayLimit{80, true}}),
            "a delay of at most 80 ms in 90 % of the presses and slips");
}

TEST(Recommend, NamesTheSettingAndWhatItHas) {
  results::TradeResult reported = figures(0.97, 150, 1, 5);
  reported.whole_runs.p90_ms.is_lower_bound = true;
  const Recommendation answer = recommend({.at_most_us = 200, .at_least_accuracy = 0.95}, "t_h 20 ms", reported,
                                          LiveTrial{.ticks = 9000, .us_p50 = 80, .us_p99 = 190, .us_p999 = 400}, false);
  EXPECT_TRUE(answer.met);
  EXPECT_EQ(
      answer.sentence,
      "For at most 200 us a tick and an accuracy of at least 95 % use t_h 20 ms. On runs that its trainings neither "
      "learned from nor were chosen on, it has an accuracy of 97.00 % [96.00, 98.00]. A tick takes 75 us [70, 80] in "
      "half of the ticks, 150 us [140, 160] in 99 of 100 and 300 us [280, 320] in 999 of 1000; other programs "
      "interrupted 0 % of them. The delay is 5.00 ms [4.50, "
      "5.50] in half of the presses and slips and at least 50.00 ms [45.00, 55.00] in 90 % of them; 10.0 % [8.0, 12.0] are "
      "missed or early. There are 1.00 [0.80, 1.20] false alarms per minute outside of touches, with those in releases and in "
      "motion without labels. In 'tactile detect' over loopback it took 80 us in half of 9000 ticks, 190 us in 99 of 100 and 400 "
      "us in 999 "
      "of 1000, and 0.00 % of the ticks were skipped or late.");
}

TEST(Recommend, DoesNotConfirmWhatIsTooSlowInDetect) {
  const LiveTrial slow{.ticks = 9000, .us_p50 = 80, .us_p99 = 210, .us_p999 = 400};
  const Recommendation answer = recommend({.at_most_us = 200}, "t_h 20 ms", figures(0.97, 150), slow, false);
  EXPECT_FALSE(answer.met);
  EXPECT_TRUE(
      answer.sentence.starts_with("The setting chosen for at most 200 us a tick, t_h 20 ms, is not confirmed: it is too slow in "
                                  "'tactile detect', where 99 of "
                                  "100 ticks must take at most 200 us. "))
      << answer.sentence;
  // Without a limit on the time, it must keep up with its ticks.
  results::TradeResult reported = figures(0.97, 150);
  reported.tick_us = 205;
  EXPECT_FALSE(recommend({.at_least_accuracy = 0.9}, "t_h 20 ms", reported, slow, false).met);
  reported.tick_us = 2000;
  EXPECT_TRUE(recommend({.at_least_accuracy = 0.9}, "t_h 20 ms", reported, slow, false).met);
}

TEST(Recommend, ReportsWhatTheMeasurementDoesNotConfirm) {
  const Recommendation answer = recommend({.at_least_accuracy = 0.95}, "t_h 20 ms", figures(0.955, 150), {}, true);
  EXPECT_FALSE(answer.met);
  EXPECT_TRUE(
      answer.sentence.starts_with("The setting chosen for an accuracy of at least 95 %, t_h 20 ms, is not confirmed: its values "
                                  "meet the constraints, but not its "
                                  "whole 95 % intervals. On runs that "))
      << answer.sentence;
  EXPECT_TRUE(answer.sentence.ends_with("On simulated runs, which say nothing about real ones.")) << answer.sentence;
  const auto is_why = [](const TradeConstraints& constraints, const results::TradeResult& reported, const char* why) {
    const std::string sentence = recommend(constraints, "t_h 20 ms", reported, {}, false).sentence;
    EXPECT_NE(sentence.find(std::string(", t_h 20 ms, is not confirmed: ") + why), std::string::npos) << sentence;
  };
  is_why({.at_least_accuracy = 0.95}, figures(0.94, 150), "on the runs to report on, its values do not meet the constraints.");
  results::TradeResult without_interval = figures(0.99, 150);
  without_interval.accuracy.low.reset();
  is_why({.at_least_accuracy = 0.95}, without_interval, "there is no 95 % interval to confirm it with.");
  is_why({.at_most_us = 200}, disturbed(figures(0.99, 8000)), "the machine was too busy to time it.");
  is_why({.at_most_us = 200, .at_least_accuracy = 0.999}, disturbed(figures(0.99, 210)),
         "on the runs to report on, its values do not meet the constraints.");
}

TEST(WhyNone, ReportsThatNoSettingMeetsTheConstraints) {
  const std::vector<results::TradeResult> compared{figures(0.9, 150), figures(0.9, 250)};
  EXPECT_EQ(why_none({.at_most_false_alarms_per_min = 0.5}, compared, 0, false),
            "No measured setting gives at most 0.5 false alarms per minute, not even on the runs to choose on.");
  EXPECT_EQ(why_none({.at_most_us = 100}, compared, 3, false),
            "No measured setting gives at most 100 us a tick, not even on the runs to choose on. 3 settings with fewer trainings "
            "were not compared: their intervals are too narrow.");
  EXPECT_TRUE(why_none({}, compared, 0, false).starts_with("No constraint given"));
}

TEST(WhyNone, ReportsThatTheMachineWasTooBusyToTell) {
  // Half of the ticks take 160 us: without other programs 99 of 100 may fit 200 us, but never 100 us.
  results::TradeResult busy = disturbed(figures(0.9, 8335));
  busy.us_p50 = figure(160, 5);
  const std::vector<results::TradeResult> compared{figures(0.9, 250), busy};
  EXPECT_TRUE(why_none({.at_most_us = 200}, compared, 0, false)
                  .starts_with("The machine was too busy to find a setting that gives at most 200 us a tick: other programs "
                               "interrupted up to 14 % of the ticks of a setting."));
  EXPECT_TRUE(why_none({.at_most_us = 100}, compared, 0, false).starts_with("No measured setting gives at most 100 us a tick"));
  busy.interrupted = 0.009;
  EXPECT_TRUE(why_none({.at_most_us = 200}, std::vector{busy}, 0, false).starts_with("No measured setting"))
      << "99 of 100 ticks were not interrupted";
}

}  // namespace
}  // namespace tactile::trade
