#include "tactile/simulation/run_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

/// Contact at 1 s, 1 mm deep in 0.2 s; lift at 2 s for 0.5 s, with ramps of 0.1 s to 100 mm/s.
RunPlan plain_plan() {
  RunPlan plan;
  plan.stage_start_s = 0.7;
  plan.contact_s = 1.0;
  plan.press_s = 0.2;
  plan.depth_mm = 1.0;
  plan.press_power = 1.0;
  plan.stage_share = 0.5;
  plan.lift_start_s = 2.0;
  plan.lift_s = 0.5;
  plan.lift_speed_mm_s = 100.0;
  plan.lift_acceleration_mm_s2 = 1000.0;
  plan.end_s = 3.0;
  return plan;
}

TEST(RunPlan, LiftsInATrapezoid) {
  const RunPlan plan = plain_plan();
  EXPECT_EQ(plan.lift_speed_at(1.9), 0.0);
  EXPECT_NEAR(plan.lift_speed_at(2.05), 50.0, 1e-9);
  EXPECT_NEAR(plan.lift_speed_at(2.3), 100.0, 1e-9);
  EXPECT_NEAR(plan.lift_speed_at(2.45), 50.0, 1e-9);
  EXPECT_EQ(plan.lift_speed_at(2.6), 0.0);
  EXPECT_EQ(plan.lift_travel_at(1.9), 0.0);
  EXPECT_NEAR(plan.lift_travel_at(2.1), 5.0, 1e-9);
  EXPECT_NEAR(plan.lift_travel_at(2.4), 35.0, 1e-9);
  EXPECT_NEAR(plan.lift_travel_at(2.45), 38.75, 1e-9);
  EXPECT_NEAR(plan.lift_travel_at(9.0), 40.0, 1e-9);
}

TEST(RunPlan, PressesFromFullSpeedToAStandstill) {
  const RunPlan plan = plain_plan();
  EXPECT_NEAR(plan.closing_speed_mm_s(), 10.0, 1e-9);
  EXPECT_EQ(plan.depth_at(1.0), 0.0);
  EXPECT_NEAR(plan.depth_at(1.001), 0.01, 1e-4);
  EXPECT_NEAR(plan.depth_at(1.1), 0.75, 1e-9);
  EXPECT_EQ(plan.depth_at(1.5), 1.0);
  // The object gives way by as much again, so the stage runs at 20 mm/s: 20 ms of ramp and 280 ms at speed are 0.2 + 5.6 mm.
  EXPECT_EQ(plan.stage_travel_at(0.6), 0.0);
  EXPECT_NEAR(plan.stage_travel_at(1.0), 5.8, 1e-9);
  EXPECT_NEAR(plan.stage_travel_at(2.0), 7.8, 1e-9);
}

TEST(DrawRunPlan, KeepsEveryObjectWithinWhatAPressAndALiftAre) {
  ASSERT_EQ(object_models().size(), 10U);
  const RunTimings timings{
      .quiet_s = {0.6, 0.8}, .travel_s = {0.2, 0.4}, .hold_s = {0.3, 0.4}, .lift_s = {0.35, 0.9}, .rest_s = {0.5, 0.6}};
  for (const ObjectModel& object : object_models()) {
    EXPECT_FALSE(object.why.empty()) << object.name;
    int on_robot_output = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      Random random(seed);
      const RunPlan plan = draw_run_plan(object, timings, random);
      EXPECT_GE(plan.stage_start_s, 0.6);
      EXPECT_GE(plan.closing_speed_mm_s(), 4.0 - 1e-9) << object.name;
      EXPECT_LE(plan.closing_speed_mm_s(), 20.0 + 1e-9) << object.name;
      EXPECT_GE(plan.press_s, 0.12);
      EXPECT_LE(plan.press_s, 0.4);
      EXPECT_GE(plan.lift_start_s - plan.contact_s - plan.press_s, 0.3 - 1e-9);
      EXPECT_GE(plan.lift_speed_mm_s, 30.0);
      EXPECT_LE(plan.lift_speed_mm_s, 120.0);
      EXPECT_GE(plan.end_s - plan.lift_start_s - plan.lift_s, 0.5 - 1e-9);
      EXPECT_GT(plan.slack_mm, 0.0);
      EXPECT_LE(plan.slack_mm, 0.2);
      EXPECT_GE(plan.stick_slip_hz, 10.0);
      EXPECT_LE(plan.stick_slip_hz, 60.0);
      double nearest = 1e9;
      for (const MarkerContact& marker : plan.markers) nearest = std::min(nearest, marker.gap_mm);
      EXPECT_EQ(nearest, 0.0);
      on_robot_output += static_cast<int>(plan.stage_on_robot_output);
    }
    EXPECT_NEAR(on_robot_output, 100, 30) << "about half of the runs";
  }
}

TEST(DrawRunClocks, GivesEachDeviceAClockOfItsOwn) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const RunClocks clocks = draw_run_clocks(random);
    for (const ClockRelation& relation : {clocks.robot, clocks.video}) {
      EXPECT_LE(std::abs(relation.drift_ppm), 100.0);
      const std::int64_t before_us = clocks.camera_start_us - us_of(relation.camera_from(relation.reference_us));
      EXPECT_GE(before_us, 100'000);
      EXPECT_LE(before_us, 1'500'000);
    }
    EXPECT_EQ(clocks.video.reference_us, 0);
    EXPECT_NE(clocks.robot.drift_ppm, clocks.video.drift_ppm);
  }
}

TEST(ObjectModel, IsFoundByName) {
  EXPECT_EQ(object_model("fan").name, "fan");
  EXPECT_THROW(object_model("cup"), Error);
}

}  // namespace
}  // namespace tactile
