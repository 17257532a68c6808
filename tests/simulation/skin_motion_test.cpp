#include "tactile/simulation/skin_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tactile/simulation/simulate.hpp"

namespace tactile {
namespace {

constexpr double dt_s = 200e-6;

/// Every marker is touched at once, pushed straight, and dragged along the image's y axis.
RunPlan plain_plan() {
  RunPlan plan;
  plan.contact_s = 0.1;
  plan.press_s = 0.2;
  plan.depth_mm = 1.0;
  plan.press_power = 1.0;
  plan.lift_start_s = 0.5;
  plan.lift_s = 0.4;
  plan.lift_speed_mm_s = 60.0;
  plan.lift_acceleration_mm_s2 = 1200.0;
  plan.end_s = 1.4;
  plan.slack_mm = 0.06;
  plan.shear_limit_mm = 0.54;
  plan.stick_slip_hz = 25.0;
  plan.stick_slip_mm = 0.1;
  plan.ring_hz = 100.0;
  plan.ring_decay_s = 0.006;
  return plan;
}

SkinMotion moved(const RunPlan& plan) {
  Random random(1);
  return move_skin(plan, 200us, random);
}

TEST(SkinMotion, StartsAndEndsAsWorkedByHand) {
  const SkinMotion motion = moved(plain_plan());
  EXPECT_EQ(motion.press_start, 100ms);
  // Speed falls evenly to nothing over 200 ms, so it passes 1 % after 198 ms.
  EXPECT_NEAR(static_cast<double>(motion.press_end.count()), 298'000, 400);
  EXPECT_EQ(motion.lift_start, 500ms);
  EXPECT_EQ(motion.slip_start, 510ms);  // 0.06 mm at 1200 mm/s^2: sqrt(2 * 0.06 / 1200) s
  // 0.6 mm of travel in all: sqrt(2 * 0.6 / 1200) = 31.6 ms, seen at the next read-out.
  EXPECT_NEAR(static_cast<double>(motion.gross.count()), 531'623, 200);
  // The arm stands still at 900 ms; its last millimetres a second are less than 1 % of a spring-back's speed.
  EXPECT_GT(motion.slip_end, 890ms);
  EXPECT_LT(motion.slip_end, 950ms);
}

TEST(SkinMotion, PushesInwardThenDragsAlongTheLift) {
  const RunPlan plan = plain_plan();
  const SkinMotion motion = moved(plan);
  ASSERT_EQ(motion.poses.size(), 7001U);
  const auto pose_at = [&](double t_s) { return motion.poses[static_cast<std::size_t>(std::lround(t_s / dt_s))]; };
  EXPECT_EQ(pose_at(0.1), skin_at_rest());
  const SkinPose pressed = pose_at(0.45);
  EXPECT_EQ(pressed, pose_at(0.5)) << "the hold is still";
  EXPECT_NEAR(pressed[0].x, 320 - 192 * (1 + 1 / 55.0), 1e-9) << "a tip pushed in by 1 mm of 55 looks larger and further out";
  EXPECT_NEAR(pressed[4].x, 320, 1e-9);
  EXPECT_NEAR(pressed[4].scale, 1 + 1 / 55.0, 1e-12);
  const SkinPose sheared = pose_at(0.5314);  // 0.59158 mm of travel less the slack
  EXPECT_NEAR(sheared[4].y - pressed[4].y, 16 * (0.5 * 1200 * 0.0314 * 0.0314 - 0.06), 1e-6);
  EXPECT_EQ(sheared[4].x, pressed[4].x);
}

TEST(SkinMotion, SticksAndSlipsAsLongAsTheArmMoves) {
  const SkinMotion motion = moved(plain_plan());
  const auto travel_px = [&](double from_s, double to_s) {
    double sum = 0;
    for (auto k = static_cast<std::size_t>(from_s / dt_s); k < static_cast<std::size_t>(to_s / dt_s); ++k) {
      sum += std::abs(motion.poses[k + 1][4].y - motion.poses[k][4].y);
    }
    return sum;
  };
  // 0.25 s hold 6 jerks, in each of which the tip goes up and down by 0.1 mm, 1.6 px, and rings.
  EXPECT_GT(travel_px(0.6, 0.85), 6 * 2 * 1.6 * 0.8);
  EXPECT_EQ(travel_px(1.0, 1.3), 0.0);
}

TEST(SkinMotion, KeepsTheRulesOfLabelsForEveryObject) {
  for (const ObjectModel& object : object_models()) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      Random random(seed);
      const RunPlan plan = draw_run_plan(object, simulation_preset("tiny").timings, random);
      const SkinMotion motion = move_skin(plan, 200us, random);
      SCOPED_TRACE(object.name + " " + std::to_string(seed));
      EXPECT_LT(motion.press_start, motion.press_end);
      EXPECT_LT(motion.press_end + 250ms, motion.lift_start);
      EXPECT_LT(motion.lift_start, motion.slip_start);
      EXPECT_LT(motion.slip_start, motion.gross);
      EXPECT_LT(motion.gross, motion.slip_end);
      EXPECT_LT(motion.slip_end + 400ms, microseconds{static_cast<std::int64_t>(1e6 * plan.end_s)});

      const auto speed_px = [&](std::size_t k) {  // the fastest marker's, from read-out k to the next
        double speed = 0;
        for (std::size_t m = 0; m < marker_count; ++m) {
          const MarkerPose &a = motion.poses[k][m], &b = motion.poses[k + 1][m];
          speed = std::max(speed, std::hypot(b.x - a.x, b.y - a.y));
        }
        return speed;
      };
      for (std::size_t k = 0; static_cast<double>(k + 1) * dt_s < plan.contact_s; ++k)
        ASSERT_EQ(speed_px(k), 0.0) << "before contact";
      const auto after_contact = static_cast<std::size_t>(plan.contact_s / dt_s) + 1;
      EXPECT_GT(speed_px(after_contact), 0.0);
      const auto still_at = [&](microseconds t) { return static_cast<std::size_t>(t / 200us); };
      for (std::size_t k = still_at(motion.slip_end) + 500; k + 1 < motion.poses.size(); ++k)
        ASSERT_EQ(speed_px(k), 0.0) << "at rest";
    }
  }
}

}  // namespace
}  // namespace tactile
