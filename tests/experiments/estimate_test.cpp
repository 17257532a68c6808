#include "tactile/experiments/estimate.hpp"

#include <gtest/gtest.h>

#include "tactile/experiments/training_speed.hpp"

namespace tactile::experiments {
namespace {

TEST(Estimate, RunsWorkOfOneThreadSideBySideAndSharesTheRest) {
  Estimate estimate;
  estimate.add({.what = "trainings", .count = 7, .exist = 2, .one_thread = true}, 30, 1e6);
  estimate.add({.what = "dataset", .count = 1}, 60, 5e6);
  estimate.add({.what = "splits", .count = 0}, 1000, 1e9);
  ASSERT_EQ(estimate.parts.size(), 2U) << "nothing is left out";
  EXPECT_EQ(estimate.processor_seconds(), 5 * 30 + 60);
  EXPECT_EQ(estimate.bytes(), 5e6 + 5e6);
  EXPECT_EQ(estimate.seconds_on(2, 2), 3 * 30 + 30) << "five trainings on two cores: one core has three of them";
  EXPECT_EQ(estimate.seconds_on(2, 16), 30 + 30) << "no training is faster than itself";
}

TEST(Estimate, DoesNotDivideWorkThatIsDoneOneAfterTheOther) {
  Estimate estimate;
  estimate.add({.what = "timed settings", .count = 10, .is_serial = true}, 3, 0);
  EXPECT_EQ(estimate.seconds_on(8, 256), 30);
}

TEST(Estimate, OfWhatExistsIsNothing) {
  Estimate estimate;
  estimate.add({.what = "trainings", .count = 3, .exist = 5, .one_thread = true}, 30, 1e6);
  EXPECT_EQ(estimate.parts.at(0).exist, 3U);
  EXPECT_EQ(estimate.seconds_on(4, 4), 0);
  EXPECT_EQ(estimate.bytes(), 0);
}

TEST(Estimate, CostsTwiceAsMuchOnAMachineOfHalfTheSpeed) {
  EXPECT_DOUBLE_EQ(work_cost(500).heatmap, 2 * work_cost(1000).heatmap);
  EXPECT_DOUBLE_EQ(work_cost(500).evaluated_tick, 2 * work_cost(1000).evaluated_tick);
}

TEST(TrainingSpeed, IsThatOfTheEngine) {
  const double fast = measured_training_speed();
  EXPECT_GT(fast, 1);
  EXPECT_GT(fast, 1.3 * measured_training_speed(model::EngineKind::libtorch));
}

}  // namespace
}  // namespace tactile::experiments
