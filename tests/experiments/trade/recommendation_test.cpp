#include "tactile/experiments/trade/recommendation.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

results::Figure figure(double value, double half_width, std::size_t n = 10) {
  results::Figure made;
  made.value = value, made.low = value - half_width, made.high = value + half_width, made.n = n;
  return made;
}

TradeFigures figures(double accuracy, double us, double alarms = 1, double delay_us = 5000) {
  return {.accuracy = figure(accuracy, 0.01),
          .us_p99 = figure(us, 10),
          .us_p50 = figure(us / 2, 5),
          .delay_us = figure(delay_us, 500),
          .false_alarms_per_min = figure(alarms, 0.2)};
}

TEST(Choose, TakesTheMostAccurateThatIsFastEnoughInItsInterval) {
  const std::vector<TradeFigures> settings{figures(0.99, 400), figures(0.95, 150), figures(0.97, 195), figures(0.94, 100)};
  const auto choice = choose({.at_most_us = 200}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U) << "the interval of the third ends at 205";
  EXPECT_TRUE(choice->in_interval);
}

TEST(Choose, TakesTheFastestThatIsAccurateEnough) {
  const std::vector<TradeFigures> settings{figures(0.99, 400), figures(0.97, 150), figures(0.90, 50)};
  const auto choice = choose({.at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U);
}

TEST(Choose, GoesByValuesOnlyWhereNoIntervalMeetsTheWish) {
  const std::vector<TradeFigures> settings{figures(0.955, 400), figures(0.90, 50)};
  const auto choice = choose({.at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 0U);
  EXPECT_FALSE(choice->in_interval);
}

TEST(Choose, TakesTheSurestWhereNoIntervalMeetsTheWish) {
  // The first is the most accurate and on the verge of both limits; the second is in the middle of what may be.
  const std::vector<TradeFigures> settings{figures(0.959, 199), figures(0.957, 195), figures(0.951, 100)};
  const auto choice = choose({.at_most_us = 200, .at_least_accuracy = 0.95}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U) << "0.5 of its half interval from the limit of time, the first 0.1, the third 0.1 from the other";
  EXPECT_FALSE(choice->in_interval);
}

TEST(Choose, FindsNothingWhereNothingMeetsEveryWish) {
  const std::vector<TradeFigures> settings{figures(0.99, 400, 0.1), figures(0.90, 50, 0.1), figures(0.99, 50, 9)};
  EXPECT_FALSE(choose({.at_most_us = 200, .at_least_accuracy = 0.95, .at_most_false_alarms_per_min = 1}, settings));
  TradeFigures unknown = figures(0.99, 50);
  unknown.accuracy = {};
  EXPECT_FALSE(choose({.at_most_us = 200}, std::vector<TradeFigures>{unknown}));
}

TEST(Choose, LeavesOutWhatDoesNotKeepUpWithItsTicks) {
  std::vector<TradeFigures> settings{figures(0.99, 620), figures(0.9, 150)};
  for (TradeFigures& one : settings) one.tick_us = 500;
  const auto choice = choose({.at_most_us = 1000}, settings);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->index, 1U);
  EXPECT_FALSE(recommend({.at_most_us = 1000}, "tick 0.5 ms", settings[0], false).met);
}

TEST(MeetsInInterval, IsNeverSoWithoutAnInterval) {
  TradeFigures two_runs = figures(0.99, 100);
  two_runs.accuracy.low = two_runs.accuracy.high = std::nullopt;
  const TradeConstraints constraint{.at_least_accuracy = 0.9};
  EXPECT_TRUE(meets(constraint, two_runs));
  EXPECT_FALSE(meets_in_interval(constraint, two_runs));
  EXPECT_TRUE(meets_in_interval({.at_most_us = 200}, two_runs)) << "no constraint on the accuracy";
}

TEST(Recommend, NamesTheSettingAndWhatItHas) {
  const Recommendation answer =
      recommend({.at_most_us = 200, .at_least_accuracy = 0.95}, "t_h 20 ms", figures(0.97, 150, 1, 5000), false);
  EXPECT_TRUE(answer.met);
  EXPECT_EQ(
      answer.sentence,
      "For at most 200 us a tick and an accuracy of at least 95 % use t_h 20 ms. Measured again, on runs that it was not "
      "chosen on, it has an accuracy of 97.00 % [96.00, 98.00], a computing time of 150 us [140, 160] in 99 of 100 ticks (75 "
      "us [70, 80] in half of them), a mean delay of 5.00 ms [4.50, 5.50] and 1.00 [0.80, 1.20] false alarms per minute.");
}

TEST(Recommend, SaysThatNoSettingDoesWhereMeasuringAgainDoesNotBearItOut) {
  const Recommendation answer = recommend({.at_least_accuracy = 0.95}, "t_h 20 ms", figures(0.955, 150), true);
  EXPECT_FALSE(answer.met);
  EXPECT_TRUE(answer.sentence.starts_with(
      "The setting chosen for an accuracy of at least 95 %, t_h 20 ms, is not confirmed. Measured again, "))
      << answer.sentence;
  EXPECT_TRUE(answer.sentence.ends_with("On simulated runs, which say nothing about real ones.")) << answer.sentence;
}

TEST(Recommend, SaysThatNoSettingDoesWhereNonePromisedIt) {
  const Recommendation answer = recommend({.at_most_false_alarms_per_min = 0.5}, std::nullopt, {}, false);
  EXPECT_FALSE(answer.met);
  EXPECT_EQ(answer.sentence, "No measured setting gives at most 0.5 false alarms per minute, not even on the runs to choose on.");
  EXPECT_TRUE(recommend({}, std::nullopt, {}, false).sentence.starts_with("No constraint given"));
}

}  // namespace
}  // namespace tactile::trade
