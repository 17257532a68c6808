#include "tactile/simulation/run_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "drawn_runs.hpp"
#include "tactile/core/fields.hpp"

namespace tactile::simulation {
namespace {

/// Contact at 1 s, 1 mm deep in 0.2 s, no creeping.
PressPlan plain_press() {
  PressPlan press;
  press.stage_start_s = 0.7;
  press.contact_s = 1.0;
  press.press_s = 0.2;
  press.depth_mm = 1.0;
  press.press_power = 1.0;
  press.stage_share = 0.5;
  return press;
}

/// That press; lift at 2 s for 0.5 s, with ramps of 0.1 s to 100 mm/s.
RunPlan plain_plan() {
  RunPlan plan;
  plan.presses = {plain_press()};
  plan.lift.emplace();
  plan.lift->start_s = 2.0;
  plan.lift->lift_s = 0.5;
  plan.lift->speed_mm_s = 100.0;
  plan.lift->acceleration_mm_s2 = 1000.0;
  plan.end_s = 3.0;
  return plan;
}

/// A lift, two taps before it, a press that creeps and is released.
RunPlan rich_plan() {
  RunPlan plan = plain_plan();
  plan.presses[0].relaxation_share = 0.02;
  plan.presses[0].relaxation_s = 0.1;
  plan.presses[0].release_start_s = 2.8;
  plan.presses[0].release_s = 0.15;
  plan.taps = {{.start_s = 0.2, .travel_mm = 3.0, .tap_s = 0.2, .depth_mm = 0.5},
               {.start_s = 0.5, .travel_mm = 2.0, .tap_s = 0.3, .depth_mm = 0.4}};
  plan.vibration = {.hz = 20, .tip_mm = 0.01, .decay_s = 0.08, .housing_share = 0.25};
  return plan;
}

double derivative(const std::function<double(double)>& f, double t, double step = 1e-6) {
  return (f(t + step) - f(t - step)) / (2 * step);
}

TEST(RunPlan, LiftsInATrapezoid) {
  const RunPlan plan = plain_plan();
  EXPECT_EQ(plan.arm_speed_at(1.9), 0.0);
  EXPECT_NEAR(plan.arm_speed_at(2.05), 50.0, 1e-9);
  EXPECT_NEAR(plan.arm_speed_at(2.3), 100.0, 1e-9);
  EXPECT_NEAR(plan.arm_speed_at(2.45), 50.0, 1e-9);
  EXPECT_EQ(plan.arm_speed_at(2.6), 0.0);
  EXPECT_EQ(plan.arm_travel_at(1.9), 0.0);
  EXPECT_NEAR(plan.arm_travel_at(2.1), 5.0, 1e-9);
  EXPECT_NEAR(plan.arm_travel_at(2.4), 35.0, 1e-9);
  EXPECT_NEAR(plan.arm_travel_at(2.45), 38.75, 1e-9);
  EXPECT_NEAR(plan.arm_travel_at(9.0), 40.0, 1e-9);
  EXPECT_EQ(plan.arm_acceleration_at(2.05), 1000.0);
  EXPECT_EQ(plan.arm_acceleration_at(2.2), 0.0);
  EXPECT_EQ(plan.arm_acceleration_at(2.45), -1000.0);
}

TEST(RunPlan, LiftsInATriangleWhereThereIsNoTimeForMore) {
  RunPlan plan = plain_plan();
  plan.lift->lift_s = 0.1;  // 0.05 s up, 0.05 s down
  EXPECT_NEAR(plan.arm_speed_at(2.05), 50.0, 1e-9);
  EXPECT_NEAR(plan.arm_travel_at(2.05), 1.25, 1e-9);
  EXPECT_NEAR(plan.arm_travel_at(2.2), 2.5, 1e-9);
}

TEST(RunPlan, GivesTheTimeOfATravel) {
  const RunPlan plan = plain_plan();
  EXPECT_EQ(plan.lift->time_of_travel(0), 2.0);
  for (const double mm : {0.1, 3.0, 5.0, 20.0, 35.0, 39.0, 40.0})
    EXPECT_NEAR(plan.arm_travel_at(plan.lift->time_of_travel(mm)), mm, 1e-9);
  EXPECT_TRUE(std::isinf(plan.lift->time_of_travel(40.1)));
}

TEST(RunPlan, PressesFromFullSpeedToAStandstill) {
  const RunPlan plan = plain_plan();
  const PressPlan& press = plan.presses[0];
  EXPECT_NEAR(press.closing_speed_mm_s(), 10.0, 1e-9);
  EXPECT_EQ(press.depth_at(1.0), 0.0);
  EXPECT_NEAR(press.depth_at(1.001), 0.01, 1e-4);
  EXPECT_NEAR(press.depth_at(1.1), 0.75, 1e-9);
  EXPECT_EQ(press.depth_at(1.5), 1.0);
  // The object gives way by as much again, so the stage runs at 20 mm/s: 20 ms of ramp and 280 ms at speed are 0.2 + 5.6 mm.
  EXPECT_EQ(plan.stage_travel_at(0.6), 0.0);
  EXPECT_NEAR(plan.stage_travel_at(1.0), 5.8, 1e-9);
  EXPECT_NEAR(plan.stage_travel_at(2.0), 7.8, 1e-9);
  EXPECT_FALSE(plan.stage_commanded_at(0.69));
  EXPECT_TRUE(plan.stage_commanded_at(0.7));
  EXPECT_TRUE(plan.stage_commanded_at(2.9));
}

TEST(RunPlan, CreepsWhileTheStageStandsStill) {
  RunPlan plan = plain_plan();
  PressPlan& press = plan.presses[0];
  press.relaxation_share = 0.02;
  press.relaxation_s = 0.1;
  EXPECT_EQ(press.depth_at(1.2), 1.0);
  EXPECT_NEAR(press.depth_at(1.3), 1.0 + 0.02 * (1 - std::exp(-1.0)), 1e-12);
  // What is left falls below 0.0006 mm after 0.1 s * ln(0.02 / 0.0006).
  EXPECT_NEAR(press.creeping_end_s(), 1.2 + 0.1 * std::log(0.02 / 0.0006), 1e-9);
  EXPECT_EQ(press.depth_at(3.0), press.depth_at(press.creeping_end_s())) << "then it stands still";
  EXPECT_EQ(plan.stage_travel_at(3.0), plan.stage_travel_at(1.2)) << "the skin gives way, not the stage";
}

TEST(RunPlan, OpensAgain) {
  RunPlan plan = plain_plan();
  PressPlan& press = plan.presses[0];
  press.release_start_s = 1.5;
  press.release_s = 0.12;  // a ramp of 20 ms, then 100 ms at speed: 0.01 + 0.1 s of it are 1 mm
  EXPECT_EQ(press.depth_at(1.5), 1.0);
  EXPECT_NEAR(press.depth_at(1.52), 1.0 - 0.01 / 0.11, 1e-9);
  EXPECT_NEAR(press.depth_at(1.57), 1.0 - 0.06 / 0.11, 1e-9);
  EXPECT_EQ(press.depth_at(1.63), 0.0);
  EXPECT_EQ(plan.press_at(0.9), nullptr);
  EXPECT_EQ(plan.press_at(1.55), &press);
  EXPECT_EQ(plan.press_at(1.63), nullptr);
  EXPECT_FALSE(plan.stage_commanded_at(1.5));
  EXPECT_NEAR(plan.stage_travel_at(1.57), 5.8 + 2 * press.depth_at(1.57), 1e-9);
  EXPECT_NEAR(plan.stage_travel_at(9.0), 0.0, 1e-9) << "back to where it came from";
}

TEST(RunPlan, ReachesTheObjectAgainFromWhereItOpenedTo) {
  RunPlan plan = plain_plan();
  plan.presses[0].release_start_s = 1.5;
  plan.presses[0].release_s = 0.1;
  PressPlan again = plain_press();
  again.stage_start_s = 2.0;
  again.contact_s = 2.12;  // 0.2 + 2 mm away
  plan.presses.push_back(again);
  EXPECT_NEAR(plan.stage_travel_at(1.99), 5.8 - 2.2, 1e-9);
  EXPECT_NEAR(plan.stage_travel_at(2.12), 5.8, 1e-9);
  EXPECT_EQ(plan.press_at(2.2), &plan.presses[1]);
  for (int ms = 0; ms < 3000; ++ms)
    ASSERT_LT(std::abs(plan.stage_travel_at((ms + 1) * 1e-3) - plan.stage_travel_at(ms * 1e-3)), 0.05) << "no leap at " << ms;
}

TEST(RunPlan, IsPressedFromTheStartWhereContactCameBefore) {
  RunPlan plan = plain_plan();
  plan.presses[0].stage_start_s = -1.3;
  plan.presses[0].contact_s = -1.0;
  EXPECT_EQ(plan.press_at(0.0), plan.presses.data());
  EXPECT_EQ(plan.presses[0].depth_at(0.0), 1.0);
  EXPECT_TRUE(plan.stage_commanded_at(0.0));
  EXPECT_EQ(plan.stage_travel_at(1.0), plan.stage_travel_at(0.0));
}

TEST(RunPlan, TapsDownAndBack) {
  const TapPlan tap{.start_s = 1.0, .travel_mm = 4.0, .tap_s = 0.2, .depth_mm = 0.5};
  EXPECT_EQ(tap.fall_at(1.0), 0.0);
  EXPECT_NEAR(tap.fall_at(1.05), 2.0, 1e-12);
  EXPECT_NEAR(tap.fall_at(1.1), 4.0, 1e-12);
  EXPECT_NEAR(tap.fall_at(1.15), 2.0, 1e-12);
  EXPECT_NEAR(tap.fall_at(1.2), 0.0, 1e-12);
  EXPECT_NEAR(tap.depth_at(1.1), 0.5, 1e-12);
  EXPECT_NEAR(tap.depth_at(tap.contact_s()), 0.0, 1e-12);
  EXPECT_NEAR(tap.fall_at(tap.contact_s()), 3.5, 1e-12);
  EXPECT_NEAR(tap.free_s() - 1.1, 1.1 - tap.contact_s(), 1e-12);
  RunPlan plan;
  plan.taps = {tap};
  EXPECT_NEAR(plan.arm_travel_at(1.1), -4.0, 1e-12) << "the arm moves upwards";
}

TEST(RunPlan, MovesAtItsStatedSpeeds) {
  const RunPlan plan = rich_plan();
  for (int i = 0; i < 638; ++i) {
    const double t_s = 0.0033 + i * 0.0047;  // away from the corners
    SCOPED_TRACE(t_s);
    EXPECT_NEAR(derivative([&](double t) { return plan.arm_travel_at(t); }, t_s), plan.arm_speed_at(t_s), 1e-3);
    EXPECT_NEAR(derivative([&](double t) { return plan.arm_speed_at(t); }, t_s), plan.arm_acceleration_at(t_s), 1e-3);
    EXPECT_NEAR(derivative([&](double t) { return plan.presses[0].depth_at(t); }, t_s), plan.presses[0].speed_at(t_s), 1e-4);
  }
}

TEST(RunPlan, RingsAtEachChangeOfTheArmsAcceleration) {
  const RunPlan plan = rich_plan();
  const std::vector<std::pair<double, double>> changes = plan.arm_acceleration_changes();
  ASSERT_EQ(changes.size(), 12U) << "four of a lift, four of each tap";
  double acceleration = 0;
  for (const auto& [at_s, change] : changes) {
    acceleration += change;
    EXPECT_NEAR(acceleration, plan.arm_acceleration_at(at_s + 1e-6), 1e-6);
  }

  RunPlan lifted = plain_plan();
  lifted.vibration = {.hz = 20, .tip_mm = 0.012, .decay_s = 0.02, .housing_share = 0.25};
  EXPECT_EQ(lifted.vibration_at(2.0), 0.0);
  // Half a period later a mass on a spring has gone as far beyond where it will rest as it still swings: 0.01 mm at 1000 mm/s^2.
  EXPECT_NEAR(lifted.vibration_at(2.025), 0.01 * (1 + std::exp(-0.025 / 0.02)), 1e-9);
  EXPECT_NEAR(lifted.vibration_at(2.0999), 0.01, 1e-9) << "it has come to rest";
  EXPECT_NEAR(lifted.vibration_at(2.39), 0.0, 1e-9);
  EXPECT_NEAR(lifted.vibration_at(2.95), 0.0, 1e-9);
  EXPECT_EQ(lifted.vibration_acceleration_at(1.9), 0.0);
  EXPECT_NEAR(lifted.vibration_acceleration_at(2.0), -250.0, 1e-6);
}

TEST(RunPlan, RingsTheHousingAsItRingsTheTips) {
  RunPlan plan = plain_plan();
  plan.vibration = {.hz = 20, .tip_mm = 1e4, .decay_s = 0.08, .housing_share = 0.25};  // so large that it never ends
  const double omega = 2 * std::numbers::pi * 20, decay = 1 / 0.08;
  const double tips_over_housing = -1e4 / 1200 * (omega * omega + decay * decay) / 0.25;
  for (int i = 0; i < 149; ++i) {
    const double t_s = 2.0031 + i * 0.0047, step = 1e-5;
    const double tips =
        (plan.vibration_at(t_s + step) - 2 * plan.vibration_at(t_s) + plan.vibration_at(t_s - step)) / (step * step);
    EXPECT_NEAR(tips / tips_over_housing, plan.vibration_acceleration_at(t_s), 1.0) << t_s;
  }
}

TEST(RunPlan, HasAllMembersInItsJson) {
  RunPlan plan = rich_plan();
  plan.micro_slips = {{.at_s = 1.5, .markers = 0b100000001, .slip_mm = 0.05}};
  const nlohmann::json json = plan;
  EXPECT_EQ(json.at("presses").size(), 1U);
  EXPECT_EQ(json.at("presses").at(0).at("markers").size(), 9U);
  EXPECT_EQ(json.at("presses").at(0).at("release_start_s").get<double>(), 2.8);
  EXPECT_EQ(json.at("taps").size(), 2U);
  EXPECT_EQ(json.at("micro_slips").at(0).at("markers"), nlohmann::json({0, 8}));
  EXPECT_EQ(json.at("lift").at("speed_mm_s").get<double>(), 100.0);
  plan.lift.reset();
  EXPECT_TRUE(nlohmann::json(plan).at("lift").is_null());
}

TEST(RunPlanSettings, AreReadBackAsTheyWereWritten) {
  RunVariation variation;
  variation.pull = {-0.5, 0.25};
  RunVariation read;
  read_fields(json_of_fields(variation), read, "test");
  EXPECT_EQ(read.pull.low, -0.5);
  EXPECT_EQ(json_of_fields(read), json_of_fields(variation));
  for (const nlohmann::json& json : {json_of_fields(RunTimings{}), json_of_fields(AfterEffects{}), json_of_fields(SpecialRuns{})})
    EXPECT_GT(json.size(), 5U);
}

}  // namespace
}  // namespace tactile::simulation
