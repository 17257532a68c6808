#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drawn_runs.hpp"
#include "tactile/core/fields.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {
namespace {

TEST(DrawRunPlan, KeepsEveryObjectWithinWhatAPressAndALiftAre) {
  ASSERT_GE(default_physics().objects.size(), 10U);
  const RunPlanOptions options = short_runs();
  const RunVariation& v = options.variation;
  for (const ObjectModel& object : default_physics().objects) {
    SCOPED_TRACE(object.name);
    int on_robot_output = 0, with_imu = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const RunPlan plan = drawn_plan(object, options, seed);
      ASSERT_EQ(plan.presses.size(), 1U);
      ASSERT_TRUE(plan.lift);
      const PressPlan& press = plan.presses[0];
      const LiftPlan& lift = *plan.lift;
      EXPECT_TRUE(plan.taps.empty());
      EXPECT_GE(press.stage_start_s, 0.6);
      EXPECT_GE(press.closing_speed_mm_s(), v.closing_speed_mm_s.low - 1e-9);
      EXPECT_LE(press.closing_speed_mm_s(), v.closing_speed_mm_s.high + 1e-9);
      EXPECT_GE(press.depth_mm, v.depth_mm.low);
      EXPECT_LE(press.depth_mm, v.depth_mm.high);
      EXPECT_GE(press.press_s, 0.1) << "a light press is done in 0.1 to 0.5 s";
      EXPECT_LE(press.press_s, 0.5);
      EXPECT_GE(lift.start_s - press.still_s(), 0.3 - 1e-9);
      EXPECT_GE(lift.speed_mm_s, v.lift_speed_mm_s.low);
      EXPECT_LE(lift.speed_mm_s, v.lift_speed_mm_s.high);
      EXPECT_GE(plan.end_s - lift.end_s(), 0.6 - 1e-9);
      EXPECT_GE(lift.slack_mm, v.slack_mm.low);
      EXPECT_LE(lift.slack_mm, v.slack_mm.high);
      EXPECT_GE(lift.stick_slip_hz, v.stick_slip_hz.low);
      EXPECT_LE(lift.stick_slip_hz, v.stick_slip_hz.high);
      EXPECT_LE(lift.stick_slip_mm, v.most_spring_back * lift.shear_limit_mm);
      double nearest = 1e9;
      for (const MarkerContact& marker : press.markers) nearest = std::min(nearest, marker.gap_mm);
      EXPECT_EQ(nearest, 0.0);
      EXPECT_LE(plan.end_s, longest_run_s(options));
      on_robot_output += static_cast<int>(plan.stage_on_robot_output);
      with_imu += static_cast<int>(plan.has_imu);
    }
    EXPECT_NEAR(on_robot_output, 100, 30) << "about half of the runs";
    EXPECT_NEAR(with_imu, 100, 30);
  }
}

TEST(DrawRunPlan, PullsTipsTowardsTheContactWhereNothingElseDoes) {
  RunPlanOptions options = short_runs();
  options.variation.pull = {1, 1};
  options.variation.skid = options.variation.pull_scatter_x = options.variation.pull_scatter_y = 0;
  options.variation.centre_mm = 0;
  const RunPlan plan = drawn_plan(default_physics().objects.front(), options, 1);
  EXPECT_NEAR(plan.presses[0].markers[4].pull_x, 0, 1e-12);
  EXPECT_NEAR(plan.presses[0].markers[3].pull_x, 1, 1e-12) << "the left one goes right";
  EXPECT_NEAR(plan.presses[0].markers[5].pull_x, -1, 1e-12);
  EXPECT_NEAR(plan.presses[0].markers[1].pull_y, 1, 1e-12);
}

TEST(DrawRunPlan, MakesLightObjectsFollowTheTips) {
  RunPlanOptions options = short_runs();
  options.variation.stick_slip_mm_spread = options.variation.shear_limit_spread = 0;
  ObjectModel object = default_physics().objects.front();
  object.stick_slip_mm = 0.1;
  object.shear_limit_mm = 0.6;
  object.weight_g = options.variation.light_object_g;
  EXPECT_NEAR(drawn_plan(object, options, 1).lift->stick_slip_mm, 0.05, 1e-12);
  object.weight_g = 3 * options.variation.light_object_g;
  EXPECT_NEAR(drawn_plan(object, options, 1).lift->stick_slip_mm, 0.075, 1e-12);
}

TEST(DrawRunPlan, AddsTheObjectsOwnStrayLight) {
  RunPlanOptions options = short_runs();
  options.variation.veil = {0.03, 0.03};
  options.variation.object_veil = {0.04, 0.04};
  ObjectModel object = default_physics().objects.front();
  object.reflectivity = 0.5;
  EXPECT_NEAR(drawn_plan(object, options, 1).veil, 0.05, 1e-12);
}

TEST(DrawRunPlan, DrawsNoSpecialRunsFirstOrForPlainPresets) {
  RunPlanOptions options = only(&SpecialRuns::without_slip);
  const ObjectModel& object = default_physics().objects.front();
  EXPECT_FALSE(drawn_plan(object, options, 1).lift);
  options.run_number = options.special.from_run - 1;
  EXPECT_TRUE(drawn_plan(object, options, 1).lift);
  options.run_number = options.special.from_run;
  options.may_be_special = false;
  EXPECT_TRUE(drawn_plan(object, options, 1).lift);
}

TEST(DrawRunPlan, DrawsSpecialRunsByTheirShares) {
  RunPlanOptions options = short_runs();
  options.special.taps = 0.25;
  options.run_number = 9;
  options.may_be_special = true;
  int two = 0, no_slip = 0, no_press = 0, taps = 0;
  const int runs = 2000;
  for (int seed = 0; seed < runs; ++seed) {
    const RunPlan plan = drawn_plan(default_physics().objects.front(), options, static_cast<std::uint64_t>(seed));
    two += static_cast<int>(plan.presses.size() == 2);
    no_slip += static_cast<int>(!plan.lift);
    no_press += static_cast<int>(plan.presses[0].contact_s < 0);
    taps += static_cast<int>(!plan.taps.empty());
    EXPECT_LE(plan.end_s, longest_run_s(options));
  }
  EXPECT_NEAR(two, 0.12 * runs, 60);
  EXPECT_NEAR(no_slip, 0.08 * runs, 50);
  EXPECT_NEAR(no_press, 0.08 * runs, 50);
  EXPECT_NEAR(taps, 0.25 * 0.92 * runs, 80) << "never with an object that is held already";
}

TEST(DrawRunPlan, OpensBetweenTwoPresses) {
  const RunPlanOptions options = only(&SpecialRuns::two_presses);
  for (const ObjectModel& object : default_physics().objects) {
    const RunPlan plan = drawn_plan(object, options, 5);
    ASSERT_EQ(plan.presses.size(), 2U);
    const PressPlan &first = plan.presses[0], &second = plan.presses[1];
    ASSERT_TRUE(first.release_start_s);
    EXPECT_GT(*first.release_start_s, first.still_s());
    EXPECT_GE(second.stage_start_s, *first.release_start_s + first.release_s + 0.3);
    EXPECT_FALSE(second.release_start_s);
    EXPECT_EQ(plan.press_at(plan.lift->start_s), &plan.presses[1]);
    EXPECT_NEAR(plan.stage_travel_at(second.contact_s), plan.stage_travel_at(first.contact_s), 1e-9)
        << "the object has not moved meanwhile";
  }
}

TEST(DrawRunPlan, HasPressedLongBeforeWhereARunHasNoPress) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const RunPlan plan = drawn_plan(default_physics().objects.back(), only(&SpecialRuns::without_press), seed);
    EXPECT_LT(plan.presses[0].creeping_end_s(), 0);
    EXPECT_GT(plan.lift->start_s, 0.5);
  }
}

TEST(DrawRunPlan, TapsAtBothEnds) {
  const RunPlan plan = drawn_plan(default_physics().objects.front(), only(&SpecialRuns::taps), 3);
  ASSERT_EQ(plan.taps.size(), 6U);
  const PressPlan& press = plan.presses[0];
  EXPECT_LT(plan.taps[2].end_s(), press.stage_start_s);
  ASSERT_TRUE(press.release_start_s) << "an object that is held would be in the way";
  EXPECT_GT(plan.taps[3].start_s, *press.release_start_s + press.release_s);
  EXPECT_LT(plan.taps[5].end_s() + 0.3, plan.end_s);
  for (std::size_t i = 0; i + 1 < plan.taps.size(); ++i) EXPECT_GT(plan.taps[i + 1].start_s, plan.taps[i].end_s());
}

TEST(DrawRunPlan, KeepsAfterEffectsClearOfPressAndLift) {
  RunPlanOptions options = short_runs();
  options.timings = {};
  options.after.micro_slips_per_s = 4;
  options.after.recontact_chance = 1;
  std::size_t micro_slips = 0, recontacts = 0;
  for (const ObjectModel& object : default_physics().objects) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const RunPlan plan = drawn_plan(object, options, seed);
      const auto is_clear = [&](double from_s, double to_s) {
        const bool held = from_s > plan.presses[0].still_s() + 0.1 && to_s < plan.lift->start_s - 0.1;
        return held || (from_s > plan.lift->end_s() + 0.35 && to_s < plan.end_s);
      };
      for (const MicroSlipPlan& slip : plan.micro_slips) {
        EXPECT_TRUE(is_clear(slip.at_s, slip.at_s));
        EXPECT_NE(slip.markers, 0U);
        for (std::size_t m = 0; m < marker_count; ++m) {
          if ((slip.markers >> m & 1U) != 0) {
            EXPECT_LT(plan.presses[0].markers[m].gap_mm, plan.presses[0].depth_mm);
          }
        }
        for (const RecontactPlan& rocks : plan.recontacts) EXPECT_TRUE(slip.at_s < rocks.start_s || slip.at_s > rocks.end_s());
      }
      for (const RecontactPlan& rocks : plan.recontacts) {
        EXPECT_GT(rocks.start_s, plan.lift->end_s() + 0.35);
        EXPECT_LT(rocks.end_s(), plan.end_s);
        EXPECT_LE(rocks.depth_mm, 0.5 * plan.presses[0].depth_mm);
      }
      micro_slips += plan.micro_slips.size();
      recontacts += plan.recontacts.size();
    }
  }
  EXPECT_GT(micro_slips, 200U);
  EXPECT_GT(recontacts, 300U);
}

TEST(DrawRunPlan, IsTheSameForTheSameSeed) {
  for (const RunPlanOptions& options : {short_runs(), only(&SpecialRuns::two_presses), only(&SpecialRuns::taps)}) {
    const ObjectModel& object = default_physics().objects.front();
    const nlohmann::json one = drawn_plan(object, options, 7), again = drawn_plan(object, options, 7);
    const nlohmann::json other = drawn_plan(object, options, 8);
    EXPECT_EQ(one, again);
    EXPECT_NE(one, other);
  }
}

/// The logarithm of the depth of each of many runs.
std::vector<double> log_depths(RunPlanOptions options, double new_share) {
  options.variation.new_share = new_share;
  options.object_seed = 7;
  std::vector<double> depths;
  for (std::uint64_t seed = 0; seed < 400; ++seed)
    depths.push_back(std::log(drawn_plan(default_physics().objects.front(), options, seed).presses[0].depth_mm));
  return depths;
}

double deviation(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value, squares += value * value;
  const double mean = sum / static_cast<double>(values.size());
  return std::sqrt(squares / static_cast<double>(values.size()) - mean * mean);
}

TEST(DrawnRuns, DifferByTheNewShareOfEachSpread) {
  RunPlanOptions options = short_runs();
  options.variation.depth_mm = {0.05, 2.0};
  options.variation.depth_spread = 0.1;
  EXPECT_NEAR(deviation(log_depths(options, 1)), 0.1, 0.015);
  EXPECT_NEAR(deviation(log_depths(options, 0.5)), 0.05, 0.008);
  EXPECT_NEAR(deviation(log_depths(options, 0.1)), 0.01, 0.0015);
}

TEST(DrawnRuns, PressAndLiftAlikeButAtOtherTimesIfNothingIsNew) {
  RunPlanOptions options = short_runs();
  options.variation.new_share = 0;
  options.object_seed = 7;
  const ObjectModel& object = default_physics().objects.front();
  const RunPlan one = drawn_plan(object, options, 1), two = drawn_plan(object, options, 2);
  EXPECT_NE(one.lift->start_s, two.lift->start_s);
  EXPECT_EQ(one.presses[0].depth_mm, two.presses[0].depth_mm);
  EXPECT_EQ(one.lift->speed_mm_s, two.lift->speed_mm_s);
  EXPECT_EQ(nlohmann::json(one).at("presses")[0].at("markers"), nlohmann::json(two).at("presses")[0].at("markers"));
  options.object_seed = 8;
  EXPECT_NE(drawn_plan(object, options, 1).presses[0].depth_mm, one.presses[0].depth_mm);
}

TEST(DrawnRuns, HaveNothingInCommonIfAllIsNew) {
  RunPlanOptions options = short_runs();
  const ObjectModel& object = default_physics().objects.front();
  options.object_seed = 7;
  const nlohmann::json one = drawn_plan(object, options, 1);
  options.object_seed = 8;
  EXPECT_EQ(nlohmann::json(drawn_plan(object, options, 1)), one);
}

}  // namespace
}  // namespace tactile::simulation
