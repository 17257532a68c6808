#include "tactile/experiments/stress/stress_figures.hpp"

#include <gtest/gtest.h>

#include <array>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile::stress {
namespace {

/// A run of which so many of 100 samples are right.
RunOutcome run_with(const std::string& object, const std::string& run, int right, std::size_t training = 0) {
  RunOutcome outcome;
  outcome.object = object;
  outcome.run = run;
  outcome.training = training;
  for (int i = 0; i < 100; ++i) outcome.confusion.add(Touch::press, i < right ? Touch::press : Touch::none);
  return outcome;
}

/// Three objects of two runs, all equally good.
std::vector<RunOutcome> runs_with(int right) {
  std::vector<RunOutcome> outcomes;
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
  const std::vector<std::vector<RunOutcome>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
  const auto holds = holds_up_to(severities, outcomes, 0.05);
  ASSERT_TRUE(holds);
  EXPECT_NEAR(holds->severity.value, 5, 1e-9);
  EXPECT_FALSE(holds->is_beyond);
  EXPECT_EQ(holds->severity.n, 3U);
}

TEST(HoldsUpTo, HasAnIntervalWhereObjectsDiffer) {
  std::vector<std::vector<RunOutcome>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
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
  EXPECT_FALSE(holds_up_to(severities, std::vector<std::vector<RunOutcome>>(3, {RunOutcome{}}), 0.05));
  std::vector<std::vector<RunOutcome>> outcomes{runs_with(90), runs_with(80), runs_with(10)};
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

TEST(RunOutcomes, AreReadAsWritten) {
  const test::TemporaryFolder folder;
  std::vector<RunOutcome> outcomes = runs_with(70);
  outcomes[1].alarms = {.alarms = 1, .none_time = microseconds{1'234'567}, .outside_labels = 3};
  outcomes[1].alarms.outside_labels_time = microseconds{7'654'321};
  outcomes[1].alarms.outside_labels_in_alarm = microseconds{54'322};
  outcomes[1].alarms.wrong_class_time = microseconds{2'000};
  outcomes[1].detections = {{.interval = {Touch::slip, camera_time(100), camera_time(900)},
                             .outcome = results::DetectionOutcome::detected,
                             .delay = microseconds{4'000},
                             .limit = microseconds{800}}};
  write_outcomes(folder / "outcomes.json", outcomes);
  const std::vector<RunOutcome> read = read_outcomes(folder / "outcomes.json", 2);
  ASSERT_EQ(read.size(), outcomes.size());
  EXPECT_EQ(read[1].object, "fan");
  EXPECT_EQ(read[1].run, "03");
  EXPECT_EQ(read[1].training, 2U);
  EXPECT_EQ(read[1].confusion, outcomes[1].confusion);
  EXPECT_EQ(nlohmann::json(read[1].alarms), nlohmann::json(outcomes[1].alarms));
  EXPECT_EQ(read[1].alarms.outside_labels_in_alarm, microseconds{54'322});
  EXPECT_EQ(nlohmann::json(read[1].detections), nlohmann::json(outcomes[1].detections));
}

}  // namespace
}  // namespace tactile::stress
