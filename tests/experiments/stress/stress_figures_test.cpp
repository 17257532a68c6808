#include "tactile/experiments/stress/stress_figures.hpp"

#include <gtest/gtest.h>

#include <array>

#include "tactile/core/error.hpp"

namespace tactile::stress {
namespace {

/// A run of which so many of 100 samples are right.
results::Cell run_with(const std::string& object, const std::string& run, int right, std::size_t training = 0) {
  results::Cell outcome;
  outcome.object = object;
  outcome.run = run;
  outcome.training = training;
  for (int i = 0; i < 100; ++i) outcome.samples.add(Touch::press, i < right ? Touch::press : Touch::none);
  return outcome;
}

/// Three objects of two runs, all equally good.
std::vector<results::Cell> runs_with(int right) {
  std::vector<results::Cell> outcomes;
  for (const char* object : {"fan", "jar", "mug"}) {
    for (const char* run : {"02", "03"}) outcomes.push_back(run_with(object, run, right));
  }
  return outcomes;
}

constexpr std::array<double, 3> severities{0, 10, 30};

TEST(SeverityWhereLost, IsLinearBetweenSeverities) {
  EXPECT_NEAR(*severity_where_lost(severities, std::array{0.9, 0.8, 0.1}, 0.05), 5, 1e-9) << "half of the first step";
  EXPECT_NEAR(*severity_where_lost(severities, std::array{0.9, 0.9, 0.8}, 0.05), 20, 1e-9) << "half of the second";
}

TEST(SeverityWhereLost, HoldsAtExactlyTheLossAllowed) {
  EXPECT_EQ(severity_where_lost(severities, std::array{0.9, 0.85, 0.85}, 0.05), std::nullopt);
  EXPECT_EQ(severity_where_lost(severities, std::array{0.9, 0.95, 0.9}, 0.05), std::nullopt) << "better is no loss";
}

TEST(SeverityWhereLost, IsTheFirstPlaceEvenIfTheAccuracyRisesAgain) {
  EXPECT_NEAR(*severity_where_lost(severities, std::array{0.9, 0.8, 0.95}, 0.05), 5, 1e-9);
}

TEST(HoldsUpTo, AveragesObjectsAndLiesWithinTheSeverities) {
  const std::vector<std::vector<results::Cell>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
  const auto holds = holds_up_to(severities, outcomes, 0.05);
  ASSERT_TRUE(holds);
  EXPECT_NEAR(holds->severity.value, 5, 1e-9);
  EXPECT_FALSE(holds->is_beyond);
  EXPECT_EQ(holds->severity.n, 3U);
}

TEST(HoldsUpTo, HasAnIntervalWhereObjectsDiffer) {
  std::vector<std::vector<results::Cell>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
  for (std::size_t i = 0; i < 2; ++i) outcomes[1][i] = run_with("fan", outcomes[1][i].run, 90);  // one object does not suffer
  const auto holds = holds_up_to(severities, outcomes, 0.05);
  ASSERT_TRUE(holds && holds->severity.has_interval());
  EXPECT_NEAR(holds->severity.value, 7.5, 1e-9) << "the mean falls by 6.67 points over 10";
  EXPECT_LT(*holds->severity.low, 7.5);
  EXPECT_GT(*holds->severity.high, 7.5);
  EXPECT_GE(*holds->severity.low, 0);
  EXPECT_LE(*holds->severity.high, 30);
}

TEST(HoldsUpTo, IsBeyondTheLastSeverityWhereNothingIsLost) {
  const auto holds = holds_up_to(severities, std::vector{runs_with(90), runs_with(90), runs_with(88)}, 0.05);
  ASSERT_TRUE(holds);
  EXPECT_TRUE(holds->is_beyond);
  EXPECT_EQ(holds->severity.value, 30);
}

TEST(HoldsUpTo, IsNothingWithoutSamplesAndRefusesOtherRuns) {
  EXPECT_FALSE(holds_up_to(severities, std::vector<std::vector<results::Cell>>(3, {results::Cell{}}), 0.05));
  std::vector<std::vector<results::Cell>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
  outcomes[2].pop_back();
  EXPECT_THROW(holds_up_to(severities, outcomes, 0.05), Error);
}

TEST(StressPoints, HaveTheChangeToTheUnchangedRuns) {
  const auto points = points_of(severities, std::vector{runs_with(90), runs_with(80), runs_with(10)}, 2);
  ASSERT_EQ(points.size(), 3U);
  EXPECT_DOUBLE_EQ(points[0].accuracy.value, 0.9);
  EXPECT_FALSE(std::isfinite(points[0].accuracy_change.value));
  EXPECT_NEAR(points[1].accuracy_change.value, -0.1, 1e-12);
  EXPECT_EQ(points[2].severity, 30);
}

}  // namespace
}  // namespace tactile::stress
