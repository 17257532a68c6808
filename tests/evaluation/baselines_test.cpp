#include "tactile/evaluation/baselines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/evaluation/baseline_scores.hpp"

namespace tactile::evaluation {
namespace {

using test::verdict_row;

TEST(Moments, OfTwoCellsAreWorkedByHand) {
  // 4 wide, 2 high: 255 at column 0 of row 0 and at column 2 of row 1, so x = 1/8 and 5/8, y = 1/4 and 3/4.
  const std::vector<std::uint8_t> heatmap{255, 0, 0, 0, 0, 0, 255, 0};
  const Features moments = moments_of(heatmap, {4, 2});
  const Features expected{0.25, 0.25, std::sqrt(0.25 - 0.0625), 1, 3.0 / 8, 0.5, 1.0 / 16, 1.0 / 16, 1.0 / 16};
  for (std::size_t i = 0; i < feature_count; ++i) EXPECT_NEAR(moments[i], expected[i], 1e-12) << i;
}

TEST(Moments, OfAnEmptyHeatmapAreCentredAndFinite) {
  const std::vector<std::uint8_t> heatmap(12, 0);
  const Features expected{0, 0, 0, 0, 0.5, 0.5, 0, 0, 0};
  EXPECT_EQ(moments_of(heatmap, {4, 3}), expected);
}

TEST(Moments, NeedTheWholeHeatmap) {
  const std::vector<std::uint8_t> heatmap(11, 0);
  EXPECT_THROW(moments_of(heatmap, {4, 3}), Error);
  EXPECT_THROW(moments_of({}, {0, 0}), Error);
}

TEST(Majority, IsTheMostFrequentAndTheEarlierOfEquals) {
  EXPECT_EQ(fit_majority(verdict_row(".ppps")).touch, Touch::press);
  EXPECT_EQ(fit_majority(verdict_row("sspp..")).touch, Touch::none);
  EXPECT_THROW(fit_majority({}), Error);
}

TEST(EventCount, FindsThresholdsBetweenSeparateCounts) {
  const std::vector<std::uint64_t> events{1, 30, 2, 11, 10, 40};
  const EventCountBaseline baseline = fit_event_count(events, verdict_row(".s.pps"));
  EXPECT_DOUBLE_EQ(baseline.low, 6);
  EXPECT_DOUBLE_EQ(baseline.high, 20.5);
  EXPECT_EQ(baseline.verdict(0), Touch::none);
  EXPECT_EQ(baseline.verdict(5), Touch::none);
  EXPECT_EQ(baseline.verdict(6), Touch::press);
  EXPECT_EQ(baseline.verdict(21), Touch::slip);
}

TEST(EventCount, PredictsAsManyRightAsTheBestPairOfThresholdsTried) {
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::uint64_t> events(25);
    std::vector<Touch> truth(25);
    for (std::size_t i = 0; i < events.size(); ++i) {
      events[i] = random.below(12);
      truth[i] = all_touches[random.below(touch_count)];
    }
    int best = 0;
    for (int low = 0; low <= 13; ++low) {
      for (int high = low; high <= 13; ++high) {
        for (int touches = 0; touches < 27; ++touches) {
          int right = 0;
          for (std::size_t i = 0; i < events.size(); ++i) {
            const int count = static_cast<int>(events[i]);
            const int predicted = count < low ? touches / 9 : count < high ? touches / 3 % 3 : touches % 3;
            right += predicted == static_cast<int>(truth[i]) ? 1 : 0;
          }
          best = std::max(best, right);
        }
      }
    }
    const EventCountBaseline baseline = fit_event_count(events, truth);
    int right = 0;
    for (std::size_t i = 0; i < events.size(); ++i) right += baseline.verdict(events[i]) == truth[i] ? 1 : 0;
    EXPECT_EQ(right, best);
  }
}

TEST(EventCount, OfOneCountPredictsTheMajority) {
  const std::vector<std::uint64_t> events{5, 5, 5};
  const EventCountBaseline baseline = fit_event_count(events, verdict_row("ss."));
  EXPECT_EQ(baseline.verdict(5), Touch::slip);
  EXPECT_THROW(fit_event_count(events, verdict_row("ss")), Error);
}

/// All moments 0 but the mean.
Features with_mean(double mean) {
  Features moments{};
  moments[1] = mean;
  return moments;
}

TEST(Logistic, GivesTheSharesOfEachGroup) {
  // Two groups that differ in one moment: without a ridge to speak of, the likeliest model says each group's own shares.
  const auto truth = verdict_row(
      "....pps"
      "..pppppsss");
  std::vector<Features> moments;
  for (std::size_t i = 0; i < truth.size(); ++i) moments.push_back(with_mean(i < 7 ? 0.2 : 0.6));
  const LogisticBaseline baseline = fit_logistic(moments, truth, {.ridge = 1e-12});
  const auto low = baseline.probabilities(with_mean(0.2)), high = baseline.probabilities(with_mean(0.6));
  EXPECT_NEAR(low[0], 4.0 / 7, 1e-6);
  EXPECT_NEAR(low[1], 2.0 / 7, 1e-6);
  EXPECT_NEAR(low[2], 1.0 / 7, 1e-6);
  EXPECT_NEAR(high[0], 0.2, 1e-6);
  EXPECT_NEAR(high[1], 0.5, 1e-6);
  EXPECT_NEAR(high[2], 0.3, 1e-6);
  EXPECT_EQ(baseline.verdict(with_mean(0.2)), Touch::none);
  EXPECT_EQ(baseline.verdict(with_mean(0.6)), Touch::press);
}

TEST(Logistic, StandardisesByTheMeanAndTheDeviationOfItsSamples) {
  const std::vector<Features> moments{with_mean(0.2), with_mean(0.4), with_mean(0.6), with_mean(0.8)};
  const LogisticBaseline baseline = fit_logistic(moments, verdict_row(".p.s"));
  EXPECT_NEAR(baseline.mean[1], 0.5, 1e-12);
  EXPECT_NEAR(baseline.deviation[1], std::sqrt(0.05), 1e-12);
  EXPECT_DOUBLE_EQ(baseline.mean[0], 0);
  EXPECT_DOUBLE_EQ(baseline.deviation[0], 1) << "it never varies";
}

TEST(Logistic, PartsSeparableSamplesWithFiniteWeights) {
  Random random(11);
  std::vector<Features> moments;
  std::vector<Touch> truth;
  for (int i = 0; i < 90; ++i) {
    const Touch touch = all_touches[static_cast<std::size_t>(i % 3)];
    Features sample{};
    for (double& moment : sample) moment = random.normal();
    sample[4] = (touch == Touch::press ? 5 : 0) + 0.1 * random.normal();
    sample[5] = (touch == Touch::slip ? 5 : 0) + 0.1 * random.normal();
    moments.push_back(sample);
    truth.push_back(touch);
  }
  const LogisticBaseline baseline = fit_logistic(moments, truth);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(baseline.verdict(moments[i]), truth[i]);
  for (const auto& row : baseline.weights) {
    for (const double weight : row) EXPECT_TRUE(std::isfinite(weight));
  }
}

TEST(Logistic, StandsWhereNoSmallStepLowersTheLoss) {
  Random random(5);
  std::vector<Features> moments(60);
  std::vector<Touch> truth(60);
  for (std::size_t i = 0; i < moments.size(); ++i) {
    for (double& moment : moments[i]) moment = random.normal() + 100;  // far from 0, as standardising must undo
    truth[i] = all_touches[random.below(touch_count)];
  }
  const double ridge = 0.01;
  const LogisticBaseline fitted = fit_logistic(moments, truth, {.ridge = ridge});
  const auto loss = [&](const LogisticBaseline& model) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < moments.size(); ++i)
      sum -= std::log(model.probabilities(moments[i])[static_cast<std::size_t>(truth[i])]);
    for (const auto& row : model.weights) {
      for (const double weight : row) squares += weight * weight;
    }
    return sum / static_cast<double>(moments.size()) + ridge / 2 * squares;
  };
  const double least = loss(fitted);
  for (std::size_t row = 0; row < fitted.weights.size(); ++row) {
    for (std::size_t i = 0; i <= feature_count; ++i) {
      for (const double step : {-1e-3, 1e-3}) {
        LogisticBaseline moved = fitted;
        moved.weights[row][i] += step;
        EXPECT_GT(loss(moved), least);
      }
    }
  }
}

TEST(Logistic, LearnsFromAClassOfOneSampleOrOfNone) {
  Random random(7);
  for (const std::size_t slips : {0U, 1U}) {
    std::vector<Features> moments(41);
    std::vector<Touch> truth(41);
    for (std::size_t i = 0; i < moments.size(); ++i) {
      truth[i] = i < slips ? Touch::slip : i % 2 == 0 ? Touch::none : Touch::press;
      for (double& moment : moments[i])
        moment = random.normal() + (truth[i] == Touch::press ? 6 : truth[i] == Touch::slip ? -6 : 0);
    }
    const LogisticBaseline baseline = fit_logistic(moments, truth);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto shares = baseline.probabilities(moments[i]);
      double sum = 0;
      for (const double share : shares) sum += share;
      EXPECT_NEAR(sum, 1, 1e-12);
      EXPECT_EQ(baseline.verdict(moments[i]), truth[i]) << i << " with " << slips << " slips";
    }
  }
}

TEST(Logistic, NeedsMomentsForEachSample) {
  const std::vector<Features> moments(2);
  EXPECT_THROW(fit_logistic(moments, verdict_row("...")), Error);
  EXPECT_THROW(fit_logistic({}, {}), Error);
}

TEST(FittedBaselines, PredictTheMostFrequentTouchOfSamplesThatLookAlike) {
  const auto samples_that_look_alike = [](std::string_view letters) {
    const std::vector<std::uint8_t> heatmap{10, 0, 0, 0, 20, 0, 0, 0, 0};
    BaselineSamples samples;
    for (const Touch touch : verdict_row(letters)) samples.add(touch, 5, heatmap, {3, 3});
    return samples;
  };
  const FittedBaselines baselines(samples_that_look_alike("psp."));
  const BaselineConfusions confusions = baselines.confusions_of(samples_that_look_alike(".ps"));
  results::Confusion all_press;
  for (const Touch truth : all_touches) all_press.add(truth, Touch::press);
  for (std::size_t i = 0; i < baseline_names.size(); ++i) EXPECT_TRUE(confusions[i] == all_press) << baseline_names[i];
}

}  // namespace
}  // namespace tactile::evaluation
