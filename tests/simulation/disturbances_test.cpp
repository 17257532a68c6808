// What may happen at any time of a run: micro-slips, partial slips, turns, firm lifts, hysteresis, drift of the light.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "drawn_runs.hpp"
#include "moved_skin.hpp"
#include "tactile/simulation/draw_disturbances.hpp"

namespace tactile::simulation {
namespace {

RunPlanOptions disturbed() {
  RunPlanOptions options = short_runs();
  options.after = {};
  options.variation = {.new_share = 1};
  options.after.micro_slips_per_s = 0;
  return options;
}

TEST(Disturbances, ComeAtTheStatedRatesAtAnyTimeWhileTheObjectIsHeld) {
  RunPlanOptions options = disturbed();
  options.after.free_micro_slips_per_s = 2;
  options.after.partial_slips_per_s = 1;
  double held_s = 0, micro = 0, partial = 0, right_before_lift = 0, right_after_lift = 0;
  for (const ObjectModel& object : default_physics().objects) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      const RunPlan plan = drawn_plan(object, options, seed);
      const unsigned touched = touched_markers(plan.presses[0]);
      held_s += plan.lift->start_s - plan.presses[0].still_s() + plan.end_s - plan.lift->end_s() - 0.02;
      for (const MicroSlipPlan& slip : plan.micro_slips) {
        EXPECT_GT(slip.at_s, plan.presses[0].still_s());
        EXPECT_TRUE(slip.at_s < plan.lift->start_s || slip.at_s > plan.lift->end_s());
        EXPECT_NE(slip.markers, 0U);
        EXPECT_EQ(slip.markers & ~touched, 0U) << "only touched tips";
        right_before_lift += slip.at_s < plan.lift->start_s && slip.at_s > plan.lift->start_s - 0.05 ? 1 : 0;
        right_after_lift += slip.at_s > plan.lift->end_s() && slip.at_s < plan.lift->end_s() + 0.05 ? 1 : 0;
        ++(slip.slip_s > 0 ? partial : micro);
        if (slip.slip_s > 0 && std::popcount(touched) > 1) {
          EXPECT_NE(slip.markers, touched) << "some tips hold";
        }
      }
    }
  }
  EXPECT_NEAR(micro, 2 * held_s, 5 * std::sqrt(2 * held_s));
  EXPECT_NEAR(partial, held_s, 5 * std::sqrt(held_s));
  EXPECT_NEAR(right_before_lift, 1000 * 0.05 * 3, 5 * std::sqrt(150));
  EXPECT_NEAR(right_after_lift, 1000 * 0.03 * 3, 5 * std::sqrt(90));
}

TEST(Disturbances, ChangeNothingElseOfARun) {
  RunPlanOptions options = disturbed();
  RunPlan plan = drawn_plan(default_physics().objects.front(), options, 4);
  RunPlan calm = drawn_plan(default_physics().objects.front(), short_runs(), 4);
  EXPECT_EQ(nlohmann::json(plan).at("presses"), nlohmann::json(calm).at("presses"));
  EXPECT_EQ(nlohmann::json(plan).at("lift"), nlohmann::json(calm).at("lift"));
  EXPECT_EQ(plan.end_s, calm.end_s);
  EXPECT_EQ(calm.light_drift.amplitude, 0);
  EXPECT_EQ(calm.hysteresis_share, 0);
}

TEST(Disturbances, AreAllInTheTruth) {
  RunPlanOptions options = disturbed();
  options.after.free_micro_slips_per_s = 3;
  options.after.partial_slips_per_s = 3;
  options.after.turn_chance = 1;
  for (const auto kind : {&SpecialRuns::two_presses, &SpecialRuns::taps, &SpecialRuns::firm_lifts}) {
    RunPlanOptions special = only(kind);
    special.after = options.after;
    for (const ObjectModel& object : default_physics().objects) {
      SCOPED_TRACE(object.name);
      Random random(3);
      const RunPlan plan = draw_run_plan(object, special, random);
      expect_true_to_poses(move_skin(plan, view, 200us, random, any_motion_px));
    }
  }
}

TEST(PartialSlip, MovesItsTipsBackSlowlyByNoMoreThanMostOfTheirBend) {
  RunPlan plan = plain_plan();
  plan.presses[0].markers[4].pull_x = 0.5;
  plan.presses[0].markers[5].pull_x = 0.1;
  plan.presses[0].markers[6].pull_x = 0.5;
  plan.micro_slips = {{.at_s = 0.35, .slip_s = 0.1, .markers = 0b110000, .slip_mm = 0.2}};
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> slips = motions_named(motion, "partial slip");
  ASSERT_EQ(slips.size(), 1U);
  EXPECT_EQ(slips[0].touch, Touch::slip);
  EXPECT_FALSE(slips[0].labelled);
  EXPECT_EQ(slips[0].start, 350ms);
  EXPECT_EQ(slips[0].end, 450ms);
  EXPECT_EQ(slips[0].markers, 0b110000U);
  const SkinPose before = pose_at(motion, 0.349), half = pose_at(motion, 0.4), after = pose_at(motion, 0.46);
  EXPECT_NEAR(after[4].x - before[4].x, -0.2 * 16, 1e-9);
  EXPECT_NEAR(half[4].x - before[4].x, -0.1 * 16, 1e-9);
  EXPECT_NEAR(after[5].x - before[5].x, -0.08 * 16, 1e-9) << "0.8 of its 0.1 mm";
  EXPECT_EQ(after[6], before[6]) << "the others hold";
  expect_true_to_poses(motion);
}

TEST(Turn, MovesTouchedTipsAboutTheMiddleOfTheSkin) {
  RunPlan plan = plain_plan();
  plan.presses[0].markers[8].gap_mm = 5;  // not touched
  plan.turns = {{.start_s = 1.0, .turn_s = 0.2, .angle_rad = 0.02}};
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> turns = motions_named(motion, "turn");
  ASSERT_EQ(turns.size(), 1U);
  EXPECT_EQ(turns[0].start, 1000ms);
  EXPECT_EQ(turns[0].end, 1200ms);
  const SkinPose before = pose_at(motion, 0.999), after = pose_at(motion, 1.21);
  for (std::size_t m = 0; m < 8; ++m) {
    EXPECT_NEAR(after[m].x - before[m].x, -0.02 * marker_y_mm(m) * 16, 1e-9);
    EXPECT_NEAR(after[m].y - before[m].y, 0.02 * marker_x_mm(m) * 16, 1e-9);
  }
  EXPECT_NEAR(after[8].x, before[8].x, 1e-9);
  expect_true_to_poses(motion);
}

TEST(Turn, IsDrawnByItsChanceWithinTheHold) {
  RunPlanOptions options = disturbed();
  options.after.turn_chance = 0.5;
  int turns = 0, clockwise = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const RunPlan plan = drawn_plan(default_physics().objects.front(), options, seed);
    for (const TurnPlan& turn : plan.turns) {
      ++turns;
      clockwise += turn.angle_rad > 0 ? 1 : 0;
      EXPECT_GE(turn.start_s, plan.presses[0].still_s());
      EXPECT_LE(turn.end_s(), plan.end_s);
      EXPECT_GE(std::abs(turn.angle_rad), options.after.turn_rad.low);
      EXPECT_LE(std::abs(turn.angle_rad), options.after.turn_rad.high);
    }
  }
  EXPECT_NEAR(turns, 500, 80);
  EXPECT_NEAR(clockwise, turns / 2.0, 60);
}

TEST(FirmLift, ShearsTheTipsUpToAnEndAndNothingSlips) {
  RunPlan plan = plain_plan();
  plan.lift->firm_mm = 0.3;
  plan.presses[0].markers[2].shear_share = 0.5;
  const SkinMotion motion = moved(plan);
  EXPECT_TRUE(motions_named(motion, "slip").empty());
  const std::vector<MarkerMotion> shears = motions_named(motion, "firm shear");
  ASSERT_EQ(shears.size(), 1U);
  EXPECT_FALSE(shears[0].labelled);
  EXPECT_FALSE(shears[0].gross);
  EXPECT_EQ(motion.lift_start, 500ms);
  EXPECT_NEAR(static_cast<double>(shears[0].start.count()), 1e6 * plan.lift->time_of_travel(0.06), 1);
  const SkinPose before = pose_at(motion, 0.499), after = pose_at(motion, 0.85);
  EXPECT_NEAR(after[4].y - before[4].y, 0.3 * 16, 0.01 * 16);
  EXPECT_NEAR(after[2].y - before[2].y, 0.15 * 16, 0.01 * 16);
  // At 0.3 mm beyond the slack, 1 - 1/e of it.
  const SkinPose then = pose_at(motion, plan.lift->time_of_travel(0.36));
  EXPECT_NEAR(then[4].y - before[4].y, 0.3 * 16 * (1 - std::exp(-1.0)), 0.05);
  for (int ms = 500; ms < 900; ++ms)
    EXPECT_GE(pose_at(motion, 1e-3 * (ms + 1))[4].y, pose_at(motion, 1e-3 * ms)[4].y - 1e-9) << ms << " ms";
  expect_true_to_poses(motion);
}

TEST(FirmLift, IsDrawnByItsShareWithAShearBelowTheLimit) {
  RunPlanOptions options = short_runs();
  options.special.firm_lifts = 0.2;
  options.run_number = options.special.from_run;
  options.may_be_special = true;
  int firm = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const RunPlan plan = drawn_plan(default_physics().objects.front(), options, seed);
    if (!plan.lift || !(plan.lift->firm_mm > 0)) continue;
    ++firm;
    EXPECT_LT(plan.lift->firm_mm, plan.lift->shear_limit_mm);
    EXPECT_EQ(plan.presses.size(), 1U) << "one thing at a time";
  }
  EXPECT_NEAR(firm, 200, 60);
}

TEST(Hysteresis, KeepsAShareOfTheDisplacementThatReturnsSlowly) {
  RunPlan plan = plain_plan();
  plan.lift.reset();
  plan.presses[0].markers[0].pull_y = 0.7;
  plan.presses[0].release_start_s = 0.5;
  plan.presses[0].release_s = 0.1;
  plan.hysteresis_share = 0.1;
  plan.hysteresis_s = 0.2;
  const SkinMotion motion = moved(plan);
  const SkinPose rest = skin_at_rest(view), held = pose_at(motion, 0.499);
  // 1 mm inward scales everything about the middle, which moves the markers too.
  const auto kept = [&](double t_s, std::size_t m) { return (pose_at(motion, t_s)[m].scale - 1) / (held[m].scale - 1); };
  EXPECT_NEAR(kept(0.6, 4), 0.1, 1e-6);
  EXPECT_NEAR(kept(0.8, 4), 0.1 * std::exp(-1.0), 1e-6);
  EXPECT_NEAR(pose_at(motion, 0.6)[0].y - rest[0].y, 0.1 * (held[0].y - rest[0].y), 1e-6) << "aside too";
  for (int ms = 500; ms < 600; ++ms)
    EXPECT_LE(pose_at(motion, 1e-3 * (ms + 1))[4].scale, pose_at(motion, 1e-3 * ms)[4].scale) << ms << " ms";
  const std::vector<MarkerMotion> recoveries = motions_named(motion, "recovery");
  ASSERT_EQ(recoveries.size(), 1U);
  EXPECT_EQ(recoveries[0].touch, Touch::press);
  EXPECT_EQ(recoveries[0].start, 600ms);
  expect_true_to_poses(motion);
}

TEST(LightDrift, IsDrawnWithinItsRangesAndIsOneAtTheStart) {
  const RunPlanOptions options = disturbed();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const LightDrift light = drawn_plan(default_physics().objects.front(), options, seed).light_drift;
    EXPECT_GE(light.amplitude, options.variation.light_drift.low);
    EXPECT_LE(light.amplitude, options.variation.light_drift.high);
    EXPECT_GE(light.period_s, options.variation.light_drift_s.low);
    EXPECT_LE(light.period_s, options.variation.light_drift_s.high);
    EXPECT_EQ(light.at(0), 1.0);
  }
}

}  // namespace
}  // namespace tactile::simulation
