#include "tactile/model/inference/two_thresholds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/error_of.hpp"
#include "tactile/model/inference/decision.hpp"

namespace tactile::model {
namespace {

constexpr microseconds two_ms{2000};

/// Probabilities with these log-odds of a class; the other touch has a tenth of the rest.
Probabilities with_log_odds(Touch touch, double log_odds) {
  const double p = 1 / (1 + std::exp(-log_odds));
  Probabilities probabilities{static_cast<float>(0.9 * (1 - p)), static_cast<float>(0.1 * (1 - p)),
                              static_cast<float>(0.1 * (1 - p))};
  probabilities[static_cast<std::size_t>(touch)] = static_cast<float>(p);
  return probabilities;
}

/// The verdicts for log-odds of slip, tick by tick: '.' none, 'p' press, 's' slip.
std::string slips_by(const TwoThresholds& settings, const std::vector<double>& log_odds_of_slip) {
  ThresholdDecision decision(settings, two_ms);
  std::string verdicts;
  for (const double odds : log_odds_of_slip)
    verdicts += ".ps"[static_cast<std::size_t>(decision.next(with_log_odds(Touch::slip, odds)))];
  return verdicts;
}

constexpr TwoThresholds example{.on = 1.4, .off = -2.6, .hold = microseconds{6000}};

TEST(TwoThresholds, ReportFromTheFirstUntilTheSecondIsUndercutForTheWholeHold) {
  EXPECT_EQ(slips_by(example, {-9, 1.3, 1.5, 0, -2.5, -9, -9, -2.5, -9, -9, -9, 1.3, 1.5}), "..ssssssss..s");
}

TEST(TwoThresholds, EndAtOnceWithoutAHold) {
  TwoThresholds at_once = example;
  at_once.hold = microseconds{0};
  EXPECT_EQ(slips_by(at_once, {2, 0, -3, 0, 2}), "ss..s");
  at_once.hold = microseconds{2001};
  EXPECT_EQ(slips_by(at_once, {2, -3, -3, 0, 2}), "ss..s") << "a hold is rounded up to whole ticks";
}

TEST(TwoThresholds, ChangeTheClassOnceTheOtherIsHigherByTheirDistance) {
  ThresholdDecision decision(example, two_ms);
  EXPECT_EQ(decision.next(with_log_odds(Touch::slip, 2)), Touch::slip);
  EXPECT_EQ(decision.next(with_log_odds(Touch::press, 5.3)), Touch::slip) << "less than 1.4 + 4";
  EXPECT_EQ(decision.next(with_log_odds(Touch::press, 5.5)), Touch::press);
  EXPECT_EQ(decision.next(with_log_odds(Touch::press, -2.5)), Touch::press);
}

TEST(TwoThresholds, CountSkippedTicksAsBelowTheSecond) {
  ThresholdDecision decision(example, two_ms);
  decision.next(with_log_odds(Touch::slip, 2));
  decision.skip(2);
  EXPECT_EQ(decision.next(with_log_odds(Touch::slip, 0)), Touch::slip) << "two ticks are shorter than the hold";
  decision.skip(std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(decision.next(with_log_odds(Touch::slip, 0)), Touch::none);
}

TEST(TwoThresholds, ConfirmASlipFromAThirdUntilItsEpisodeEnds) {
  ThresholdDecision decision(example, two_ms);
  const auto confirms = [&](Touch touch, double odds) {
    decision.next(with_log_odds(touch, odds));
    return decision.confirms_slip();
  };
  EXPECT_FALSE(confirms(Touch::slip, 1.5));
  EXPECT_FALSE(confirms(Touch::slip, 3.4));
  EXPECT_TRUE(confirms(Touch::slip, 3.6));
  EXPECT_TRUE(confirms(Touch::slip, 0)) << "it stays";
  EXPECT_FALSE(confirms(Touch::press, 9));
  EXPECT_FALSE(confirms(Touch::slip, 5.3)) << "press is reported still";
  EXPECT_TRUE(confirms(Touch::slip, 9));
  decision.skip(100);
  EXPECT_FALSE(decision.confirms_slip());
  EXPECT_TRUE(confirms(Touch::slip, 9));
  decision.restart();
  EXPECT_FALSE(decision.confirms_slip());
  RunningDecision single({}, two_ms);
  single.next(Touch::slip, {});
  EXPECT_TRUE(single.confirms_slip()) << "without thresholds every slip is";
  single.next(Touch::press, {});
  EXPECT_FALSE(single.confirms_slip());
}

TEST(TwoThresholds, BeginInNoneAfterARestart) {
  ThresholdDecision decision(example, two_ms);
  EXPECT_EQ(decision.next(with_log_odds(Touch::press, 2)), Touch::press);
  decision.restart();
  EXPECT_EQ(decision.next(with_log_odds(Touch::press, 0)), Touch::none);
}

TEST(TwoThresholds, HaveFiniteLogOddsOfCertainProbabilities) {
  EXPECT_NEAR(log_odds({0.2F, 0.2F, 0.6F}, Touch::slip), std::log(1.5), 1e-6);
  EXPECT_NEAR(log_odds({1, 0, 0}, Touch::slip), -87.3, 0.1);
  EXPECT_NEAR(log_odds({0, 0, 1}, Touch::slip), 87.3, 0.1);
}

TEST(TwoThresholds, AreTheSameTickByTickAndOverARun) {
  std::vector<Probabilities> probabilities;
  probabilities.reserve(200);
  for (int i = 0; i < 200; ++i)
    probabilities.push_back(with_log_odds(i % 50 < 30 ? Touch::slip : Touch::press, 4 * std::sin(0.3 * i)));
  const Decision decision{.thresholds = example};
  const std::vector<Touch> predicted(probabilities.size());
  RunningDecision running(decision, two_ms);
  std::vector<Touch> one_by_one;
  one_by_one.reserve(probabilities.size());
  for (const Probabilities& p : probabilities) one_by_one.push_back(running.next(Touch::none, p));
  EXPECT_EQ(decided(decision, two_ms, predicted, probabilities), one_by_one);
}

TEST(TwoThresholds, AreReadFromTextAndWrittenToIt) {
  EXPECT_EQ(two_thresholds_in("1.4:-2.6:6"), example);
  EXPECT_EQ(text_of(example), "1.4:-2.6:6:3.5");
  EXPECT_EQ(two_thresholds_in("1.4:-2.6:6:3.5"), example);
  EXPECT_EQ(two_thresholds_in("5:1:6").confirmed, 5);
  EXPECT_EQ(moved_to(example, 9).confirmed, 9);
  EXPECT_EQ(moved_to(example, 2), (TwoThresholds{.on = 2, .off = -2, .hold = example.hold}));
  for (const char* wrong : {"", "1", "1:2:20", "2:1", "2:1:-1", "2:1:20:1.9", "2:1:20:3:4", "2:x:20", "nan:0:20", "2:1:10001"})
    EXPECT_NE(test::error_of([&] { two_thresholds_in(wrong); }).find("; expected "), std::string::npos) << wrong;
}

}  // namespace
}  // namespace tactile::model
