#include "tactile/evaluation/operating_curve.hpp"

#include <gtest/gtest.h>

#include "support/verdict_row.hpp"

namespace tactile::evaluation {
namespace {

using test::verdict_row;

TEST(VerdictsAbove, AreTheMoreProbableTouchFromTheThresholdOn) {
  const std::vector<model::Probabilities> probabilities{
      {0.8F, 0.15F, 0.05F}, {0.4F, 0.25F, 0.35F}, {0.0F, 0.5F, 0.5F}, {0.0F, 0.25F, 0.75F}, {1.0F, 0.0F, 0.0F}};
  EXPECT_EQ(verdicts_above(probabilities, 0.1), verdict_row("psps."));
  EXPECT_EQ(verdicts_above(probabilities, 0.5), verdict_row("..ps."));
  EXPECT_EQ(verdicts_above(probabilities, 0.75), verdict_row("...s."));
  EXPECT_EQ(verdicts_above(probabilities, 0.76), verdict_row("....."));
}

TEST(DefaultThresholds, AscendWithinZeroAndOne) {
  const auto& thresholds = default_thresholds();
  EXPECT_GT(thresholds.front(), 0);
  EXPECT_LT(thresholds.back(), 1);
  for (std::size_t i = 1; i < thresholds.size(); ++i) EXPECT_LT(thresholds[i - 1], thresholds[i]);
}

TEST(OperatingPoint, HoldsDelaysAndFalseAlarmsOfAllRuns) {
  const results::Detection press{{Touch::press, {}, {}}, results::DetectionOutcome::detected, 6ms, {}, {}};
  const results::Detection missed{{Touch::press, {}, {}}, results::DetectionOutcome::missed, 0us, {}, {}};
  results::FalseAlarms alarms;
  alarms.alarms = 2;
  alarms.none_time = 30s;
  const std::vector<results::RunDetections> detections{{{"fan"}, {press}}, {{"box"}, {missed}}};
  const std::vector<RunFalseAlarms> false_alarms{{{"fan"}, alarms}, {{"box"}, alarms}};
  const nlohmann::json json = operating_point(0.9, detections, false_alarms);
  EXPECT_EQ(json.at("threshold"), 0.9);
  EXPECT_EQ(json.at("delay_ms").at("press").at("mean").at("value"), 6.0);
  EXPECT_EQ(json.at("delay_ms").at("press").at("misses"), 1);
  EXPECT_TRUE(json.at("delay_ms").at("slip").at("mean").at("value").is_null());
  EXPECT_EQ(json.at("false_alarms_per_min").at("value"), 4.0);
  EXPECT_EQ(json.at("false_alarms"), 4);
}

}  // namespace
}  // namespace tactile::evaluation
