#include "tactile/model/inference/decision.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace tactile::model {
namespace {

constexpr microseconds tick{2000};

TEST(Decision, WithoutThresholdsConfirms) {
  const std::vector<Touch> predicted{Touch::slip, Touch::none, Touch::slip, Touch::slip};
  EXPECT_EQ(decided({.confirmation = {2, 3}}, tick, predicted, {}), confirmed(predicted, {2, 3}));
  RunningDecision running({.confirmation = {2, 3}}, tick);
  std::vector<Touch> verdicts;
  verdicts.reserve(predicted.size());
  for (const Touch touch : predicted) verdicts.push_back(running.next(touch, {}));
  EXPECT_EQ(verdicts, confirmed(predicted, {2, 3}));
}

TEST(Decision, WithThresholdsTakesNoHeedOfTheConfirmation) {
  const TwoThresholds thresholds{.on = 1, .off = -1, .hold = 4ms};
  const std::vector<Probabilities> probabilities{{0.1F, 0, 0.9F}, {0.9F, 0, 0.1F}, {1, 0, 0}, {1, 0, 0}};
  ThresholdDecision alone(thresholds, tick);
  std::vector<Touch> expected(probabilities.size());
  std::transform(probabilities.begin(), probabilities.end(), expected.begin(),
                 [&](const Probabilities& of_tick) { return alone.next(of_tick); });
  EXPECT_EQ(expected.front(), Touch::slip);
  EXPECT_EQ(decided({.confirmation = {2, 3}, .thresholds = thresholds}, tick, std::vector<Touch>(4), probabilities), expected);
}

}  // namespace
}  // namespace tactile::model
