#include "tactile/simulation/skin_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drawn_runs.hpp"
#include "moved_skin.hpp"

namespace tactile::simulation {
namespace {

TEST(SkinMotion, StartsAndEndsAsWorkedByHand) {
  const SkinMotion motion = moved(plain_plan());
  const std::vector<MarkerMotion> presses = motions_named(motion, "press"), slips = motions_named(motion, "slip");
  ASSERT_EQ(presses.size(), 1U);
  ASSERT_EQ(slips.size(), 1U);
  EXPECT_TRUE(presses[0].labelled);
  EXPECT_EQ(presses[0].touch, Touch::press);
  EXPECT_EQ(presses[0].start, 100'050us);
  // Speed falls evenly to nothing over 200 ms, so it passes 1 % after 198 ms.
  EXPECT_NEAR(static_cast<double>(presses[0].end.count()), 298'050, 1);
  EXPECT_EQ(motion.lift_start, 500ms);
  EXPECT_EQ(slips[0].touch, Touch::slip);
  EXPECT_EQ(slips[0].start, 510ms);      // 0.06 mm at 1200 mm/s^2: sqrt(2 * 0.06 / 1200) s
  EXPECT_EQ(slips[0].gross, 531'623us);  // 0.6 mm of travel in all: sqrt(2 * 0.6 / 1200) s
  // The arm stands still at 900 ms; its last millimetres a second are less than 1 % of a spring-back's speed.
  EXPECT_GT(slips[0].end, 890ms);
  EXPECT_LT(slips[0].end, 950ms);
  EXPECT_NE(slips[0].end.count() % 200, 0) << "between read-outs";
  expect_true_to_poses(motion);
}

TEST(SkinMotion, PushesInwardThenDragsAlongTheLift) {
  const SkinMotion motion = moved(plain_plan());
  ASSERT_EQ(motion.poses.size(), 7001U);
  EXPECT_EQ(pose_at(motion, 0.1), skin_at_rest(view));
  const SkinPose pressed = pose_at(motion, 0.45);
  EXPECT_EQ(pressed, pose_at(motion, 0.5)) << "the hold is still";
  EXPECT_NEAR(pressed[0].x, 320 - 192 * (1 + 1 / 55.0), 1e-9) << "a tip pushed in by 1 mm of 55 looks larger and further out";
  EXPECT_NEAR(pressed[4].x, 320, 1e-9);
  EXPECT_NEAR(pressed[4].scale, 1 + 1 / 55.0, 1e-12);
  const SkinPose sheared = pose_at(motion, 0.5314);  // 0.59158 mm of travel less the slack
  for (std::size_t m = 0; m < marker_count; ++m) {
    EXPECT_NEAR(sheared[m].y - pressed[m].y, 16 * (0.5 * 1200 * 0.0314 * 0.0314 - 0.06), 1e-6) << "all alike";
    EXPECT_EQ(sheared[m].x, pressed[m].x);
  }
}

TEST(SkinMotion, SticksAndSlipsAsLongAsTheArmMoves) {
  const SkinMotion motion = moved(plain_plan());
  const auto travel_px = [&](double from_s, double to_s) {
    double sum = 0;
    for (auto k = static_cast<std::size_t>(from_s / dt_s); k < static_cast<std::size_t>(to_s / dt_s); ++k)
      sum += std::abs(motion.poses[k + 1][4].y - motion.poses[k][4].y);
    return sum;
  };
  // 0.25 s hold 6 jerks, in each of which the tip goes up and down by 0.1 mm, 1.6 px, and rings.
  EXPECT_GT(travel_px(0.6, 0.85), 6 * 2 * 1.6 * 0.8);
  EXPECT_EQ(travel_px(1.0, 1.3), 0.0);
}

TEST(SkinMotion, EndsAPressOnlyWhenItsCreepingIsSlowEnough) {
  RunPlan plan = plain_plan();
  // The press begins at 10 mm/s; the tips then creep from 0.2 mm/s on, and below 0.1 mm/s after 0.1 s * ln 2.
  plan.presses[0].relaxation_share = 0.02;
  plan.presses[0].relaxation_s = 0.1;
  const SkinMotion motion = moved(plan);
  const double end_s = 0.30005 + 0.1 * std::log(2.0);
  EXPECT_NEAR(static_cast<double>(motions_named(motion, "press").at(0).end.count()), 1e6 * end_s, 1);
  const std::vector<MarkerMotion> creeping = motions_named(motion, "relaxation");
  ASSERT_FALSE(creeping.empty());
  EXPECT_EQ(creeping[0].start, motions_named(motion, "press").at(0).end);
  EXPECT_EQ(creeping[0].touch, Touch::press);
  EXPECT_FALSE(creeping[0].labelled);
  // Slower creeping, after a standstill shorter than 20 ms, does not belong to the press.
  plan.presses[0].relaxation_share = 0.005;
  EXPECT_NEAR(static_cast<double>(motions_named(moved(plan), "press").at(0).end.count()), 298'050, 1);
}

TEST(SkinMotion, CountsCreepingAfterAStandstillOfLessThan20ms) {
  RunPlan plan = plain_plan();
  plan.presses[0].press_power = 3;  // slow for its last (1 / 100)^(1/3) = 22 % of 0.02 s
  plan.presses[0].press_s = 0.02;
  plan.presses[0].depth_mm = 0.1;
  plan.presses[0].relaxation_share = 0.2;
  plan.presses[0].relaxation_s = 0.05;  // 0.4 mm/s at first, after 4.3 ms; 0.2 mm/s is 1 % of the peak
  EXPECT_NEAR(static_cast<double>(motions_named(moved(plan), "press").at(0).end.count()), 1e6 * (0.12005 + 0.05 * std::log(2.0)),
              1);
}

TEST(SkinMotion, RingsWithTheArmDuringTheSlip) {
  RunPlan plan = plain_plan();
  plan.vibration = {.hz = 20, .tip_mm = 0.01, .decay_s = 0.05};
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> rings = motions_named(motion, "vibration");
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_EQ(rings[0].start, 500ms);
  EXPECT_EQ(rings[0].end, 510ms) << "from there on the slip is listed";
  const MarkerMotion slip = motions_named(motion, "slip").at(0);
  EXPECT_EQ(rings[1].start, slip.end);
  EXPECT_NEAR(static_cast<double>(rings[1].end.count()), 1e6 * (0.9 + 0.05 * std::log(0.01 / 0.0006)), 1);
  EXPECT_GT(distance_px(pose_at(motion, 0.51), pose_at(motion, 0.5)), 0.0);
  expect_true_to_poses(motion);
}

TEST(SkinMotion, LetsAMicroSlipSpringBackAgainstTheBend) {
  RunPlan plan = plain_plan();
  plan.presses[0].markers[4].pull_x = 0.5;
  plan.micro_slips = {{.at_s = 0.4, .markers = 0b10000, .slip_mm = 0.05, .ring_hz = 100, .ring_decay_s = 0.006}};
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> slips = motions_named(motion, "micro-slip");
  ASSERT_EQ(slips.size(), 1U);
  EXPECT_EQ(slips[0].touch, Touch::slip);
  EXPECT_EQ(slips[0].start, 400ms);
  EXPECT_EQ(slips[0].markers, 0b10000U);
  EXPECT_NEAR(static_cast<double>(slips[0].end.count()), 1e6 * (0.4 + 0.006 * std::log(0.05 / 0.0006)), 1);
  const SkinPose before = pose_at(motion, 0.399), half = pose_at(motion, 0.405), after = pose_at(motion, 0.49);
  EXPECT_NEAR(after[4].x - before[4].x, -0.05 * 16, 1e-9);
  EXPECT_NEAR(half[4].x - before[4].x, -0.05 * 16 * (1 + std::exp(-0.005 / 0.006)), 1e-9) << "half a ring";
  EXPECT_EQ(after[4].y, before[4].y);
  EXPECT_EQ(after[3], before[3]) << "the others stay";
  expect_true_to_poses(motion);
}

TEST(SkinMotion, RocksTheObjectInAReContact) {
  RunPlan plan = plain_plan();
  plan.recontacts = {{.start_s = 1.2, .recontact_s = 0.1, .depth_mm = 0.2}};
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> rocks = motions_named(motion, "re-contact");
  ASSERT_EQ(rocks.size(), 1U);
  EXPECT_EQ(rocks[0].touch, Touch::press);
  EXPECT_EQ(rocks[0].start, 1200ms);
  EXPECT_EQ(rocks[0].end, 1300ms);
  EXPECT_NEAR(pose_at(motion, 1.25)[4].scale, 1 + 0.8 / 55, 1e-12);
  EXPECT_EQ(pose_at(motion, 1.31), pose_at(motion, 1.19));
  expect_true_to_poses(motion);
}

TEST(SkinMotion, StraightensTheTipsInARelease) {
  RunPlan plan = plain_plan();
  plan.presses[0].markers[0].pull_y = 0.7;
  plan.presses[0].release_start_s = 1.1;
  plan.presses[0].release_s = 0.15;
  const SkinMotion motion = moved(plan);
  const std::vector<MarkerMotion> releases = motions_named(motion, "release");
  ASSERT_EQ(releases.size(), 1U);
  EXPECT_EQ(releases[0].touch, Touch::press);
  EXPECT_EQ(releases[0].start, 1100ms);
  EXPECT_EQ(releases[0].end, 1250ms);
  EXPECT_GT(distance_px(pose_at(motion, 1.09), skin_at_rest(view)), 5);
  EXPECT_LT(distance_px(pose_at(motion, 1.2496), skin_at_rest(view)), 0.2) << "no leap at its end";
  EXPECT_EQ(pose_at(motion, 1.26), skin_at_rest(view));
  expect_true_to_poses(motion);
}

TEST(SkinMotion, PushesAllTipsInWithATap) {
  RunPlan plan;
  plan.taps = {{.start_s = 0.3, .travel_mm = 3.0, .tap_s = 0.2, .depth_mm = 0.5}};
  plan.end_s = 1;
  const SkinMotion motion = moved(plan);
  ASSERT_EQ(motion.motions.size(), 1U);
  EXPECT_EQ(motion.motions[0].what, "tap");
  EXPECT_FALSE(motion.motions[0].labelled);
  EXPECT_FALSE(motion.lift_start);
  // 0.5 mm above the lowest point, at 16 * 3 / 0.2^2 = 1200 mm/s^2: sqrt(2 * 0.5 / 1200) s before and after it.
  EXPECT_EQ(motion.motions[0].start, 371'132us);
  EXPECT_EQ(motion.motions[0].end, 428'868us);
  for (const MarkerPose& marker : pose_at(motion, 0.4)) EXPECT_NEAR(marker.scale, 1 + 0.5 / 55, 1e-12);
  EXPECT_EQ(pose_at(motion, 0.43), skin_at_rest(view));
  expect_true_to_poses(motion);
}

TEST(SkinMotion, HasNoLabelForWhatWasPressedBeforeTheRecording) {
  RunPlan plan = plain_plan();
  plan.presses[0].contact_s = -0.5;
  const SkinMotion before = moved(plan);
  EXPECT_TRUE(motions_named(before, "press").empty());
  EXPECT_EQ(motions_named(before, "slip").size(), 1U);
  EXPECT_NEAR(before.poses[0][4].scale, 1 + 1 / 55.0, 1e-12);
  expect_true_to_poses(before);
  plan.presses[0].contact_s = -0.05;  // still being pressed
  const std::vector<MarkerMotion> rest = motions_named(moved(plan), "press");
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_FALSE(rest[0].labelled);
  EXPECT_EQ(rest[0].start, 0us);
}

TEST(SkinMotion, EndsAPressWhereTheSlipStarts) {
  RunPlan plan = plain_plan();
  plan.lift->start_s = 0.25;  // before the stage stands still
  const SkinMotion motion = moved(plan);
  EXPECT_EQ(motions_named(motion, "slip").at(0).start, 260ms);
  EXPECT_EQ(motions_named(motion, "press").at(0).end, 260ms);
}

TEST(SkinMotion, HasNoSlipWithoutContact) {
  RunPlan plan = plain_plan();
  plan.presses[0].release_start_s = 0.35;
  plan.presses[0].release_s = 0.1;
  const SkinMotion motion = moved(plan);
  EXPECT_TRUE(motions_named(motion, "slip").empty());
  EXPECT_EQ(motion.lift_start, 500ms);
  EXPECT_EQ(pose_at(motion, 0.7), skin_at_rest(view));
}

TEST(SkinMotion, ListsUnlabelledMotionOnlyUntilItHasLastCausedEvents) {
  RunPlan plan = plain_plan();
  plan.presses[0].relaxation_share = 0.02;
  plan.presses[0].relaxation_s = 0.1;
  for (std::size_t m = 1; m < marker_count; ++m) plan.presses[0].markers[m].gap_mm = 5;  // one tip is touched
  const SkinMotion all = moved(plan);
  const MarkerMotion press = motions_named(all, "press").at(0);
  const double end_s = 1e-6 * static_cast<double>(press.end.count());
  // The tips creep by c (1 - exp(-t / 0.1 s)), of which half a time constant shows the share 0.39.
  const double c_px = distance_px(pose_at(all, end_s), pose_at(all, end_s + 0.05)) / (1 - std::exp(-0.5));
  const std::vector<MarkerMotion> creeping = motions_named(moved(plan, view, 0.6 * c_px), "relaxation");
  ASSERT_EQ(creeping.size(), 1U);
  EXPECT_EQ(creeping[0].start, press.end);
  EXPECT_NEAR(static_cast<double>((creeping[0].end - press.end).count()), -1e5 * std::log(1 - 0.6), 800);
  EXPECT_TRUE(motions_named(moved(plan, view, c_px), "relaxation").empty());
}

TEST(SkinMotion, MovesHalfAsManyPixelsInHalfAsLargeAnImage) {
  RunPlanOptions options = short_runs();
  options.after.micro_slips_per_s = 2;
  const RunPlan plan = drawn_plan(default_physics().objects.front(), options, 4);
  const SkinView small = view_of_skin({320, 240});
  const SkinMotion large_motion = moved(plan), small_motion = moved(plan, small);
  ASSERT_EQ(small_motion.poses.size(), large_motion.poses.size());
  for (std::size_t k = 0; k < large_motion.poses.size(); k += 97) {
    for (std::size_t m = 0; m < marker_count; ++m) {
      EXPECT_NEAR(small_motion.poses[k][m].x, large_motion.poses[k][m].x / 2, 1e-9);
      EXPECT_NEAR(small_motion.poses[k][m].y, large_motion.poses[k][m].y / 2, 1e-9);
      EXPECT_EQ(small_motion.poses[k][m].scale, large_motion.poses[k][m].scale);
    }
  }
  ASSERT_EQ(small_motion.motions.size(), large_motion.motions.size());
  for (std::size_t i = 0; i < large_motion.motions.size(); ++i)
    EXPECT_EQ(small_motion.motions[i].end, large_motion.motions[i].end);
  expect_true_to_poses(small_motion, small);
}

TEST(SkinMotion, IsTheSameForTheSameSeed) {
  const RunPlan plan = drawn_plan(default_physics().objects.front(), short_runs(), 4);
  EXPECT_EQ(moved(plan).poses, moved(plan).poses);
  Random other(2);
  EXPECT_NE(move_skin(plan, view, 200us, other).poses, moved(plan).poses);
}

TEST(SkinMotion, KeepsTheRulesOfLabelsForEveryObjectAndKindOfRun) {
  std::vector<std::pair<std::string, RunPlanOptions>> kinds{{"plain", short_runs()}, {"lively", short_runs()}};
  kinds[1].second.after.micro_slips_per_s = 4;
  kinds[1].second.after.recontact_chance = 1;
  kinds.emplace_back("two presses", only(&SpecialRuns::two_presses));
  kinds.emplace_back("without slip", only(&SpecialRuns::without_slip));
  kinds.emplace_back("without press", only(&SpecialRuns::without_press));
  kinds.emplace_back("taps", only(&SpecialRuns::taps));
  for (const auto& [kind, options] : kinds) {
    for (const ObjectModel& object : default_physics().objects) {
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        SCOPED_TRACE(kind + " of " + object.name + " " + std::to_string(seed));
        Random random(seed);
        const RunPlan plan = draw_run_plan(object, options, random);
        const SkinMotion motion = move_skin(plan, view, 200us, random, any_motion_px);
        expect_true_to_poses(motion);
        const std::vector<MarkerMotion> presses = motions_named(motion, "press"), slips = motions_named(motion, "slip");
        ASSERT_EQ(presses.size(), kind == "two presses" ? 2U : kind == "without press" ? 0U : 1U);
        ASSERT_EQ(slips.size(), kind == "without slip" ? 0U : 1U);
        for (const MarkerMotion& press : presses) {
          EXPECT_GT(press.end - press.start, 80ms);
          EXPECT_LT(press.end - press.start, 900ms);
        }
        if (!slips.empty()) {
          EXPECT_LT(motion.lift_start, slips[0].start);
          ASSERT_TRUE(slips[0].gross);
          if (!presses.empty()) {
            EXPECT_LT(presses.back().end + 20ms, slips[0].start);
          }
          const microseconds lift_end{std::llround(1e6 * plan.lift->end_s())};
          EXPECT_GT(slips[0].end, lift_end - 20ms) << "stick phases belong to it";
          EXPECT_LT(slips[0].end, lift_end + 200ms);
        }
        // Nothing that a label's end is judged by stirs within 20 ms of a press or 150 ms of a slip.
        for (const MarkerMotion& one : motion.motions) {
          if (one.what != "micro-slip" && one.what != "re-contact") continue;
          for (const MarkerMotion& press : presses) EXPECT_TRUE(one.end < press.start || one.start > press.end + 20ms);
          for (const MarkerMotion& slip : slips) EXPECT_TRUE(one.end < slip.start || one.start > slip.end + 150ms);
        }
        // The markers stay apart and inside the image, with room for the lens' blur.
        for (std::size_t k = 0; k < motion.poses.size(); k += 50) {
          for (std::size_t m = 0; m < marker_count; ++m) {
            const MarkerPose& marker = motion.poses[k][m];
            const double half_width = 32 * marker.scale + 3, half_height = 8 * marker.scale + 3;
            ASSERT_TRUE(marker.x > half_width && marker.x < 640 - half_width);
            ASSERT_TRUE(marker.y > half_height && marker.y < 480 - half_height);
            if (m % 3 != 0) {
              ASSERT_GT(marker.x - motion.poses[k][m - 1].x, 2 * half_width);
            }
            if (m >= 3) {
              ASSERT_GT(marker.y - motion.poses[k][m - 3].y, 2 * half_height);
            }
          }
        }
      }
    }
  }
}

/// How alike the touched markers' ways between two times are: 1 where all go the same way, 0 where they go all ways.
double unison(const SkinMotion& motion, microseconds from, microseconds to) {
  double sum_x = 0, sum_y = 0, sum = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    const MarkerPose &a = motion.poses[static_cast<std::size_t>(from / 200us)][m],
                     &b = motion.poses[static_cast<std::size_t>(to / 200us)][m];
    sum_x += b.x - a.x;
    sum_y += b.y - a.y;
    sum += std::hypot(b.x - a.x, b.y - a.y);
  }
  return std::hypot(sum_x, sum_y) / sum;
}

TEST(SkinMotion, MovesTipsTogetherInASlipAndTowardsEachOtherInAPress) {
  double press = 0, slip = 0;
  int runs = 0;
  for (const ObjectModel& object : default_physics().objects) {
    for (std::uint64_t seed = 0; seed < 10; ++seed, ++runs) {
      Random random(seed);
      const SkinMotion motion = move_skin(draw_run_plan(object, short_runs(), random), view, 200us, random, any_motion_px);
      const MarkerMotion pressed = motions_named(motion, "press").at(0), slipped = motions_named(motion, "slip").at(0);
      press += unison(motion, pressed.start, pressed.end);
      slip += unison(motion, slipped.start, *slipped.gross);
    }
  }
  EXPECT_GT(slip / runs, 0.97);
  EXPECT_LT(press / runs, 0.6);
}

}  // namespace
}  // namespace tactile::simulation
