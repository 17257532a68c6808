#include "tactile/labels/posterior/motion_course.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tactile/core/random.hpp"

namespace tactile::labels {
namespace {

/// An arm that rests for a second, lifts for a second and rests again. From 0 to the full speed it takes 100 ms, with a smooth
/// acceleration. After its stop it rings.
struct Lift {
  double mm_per_s = 20, noise_mm_per_s = 0.05, rings_mm_per_s = 0;
};

alignment::ArmMotion motion_of(const Lift& lift) {
  alignment::ArmMotion motion;
  Random random(4);
  const auto rises = [](double s) { return s < 0.5 ? 2 * s * s : 1 - 2 * (1 - s) * (1 - s); };
  for (std::size_t i = 0; i < 750; ++i) {
    const double t = 0.004 * static_cast<double>(i);
    double speed = 0;
    if (t > 1 && t < 2) speed = lift.mm_per_s * rises(std::min({1.0, (t - 1) / 0.1, (2 - t) / 0.1}));
    if (t > 2) speed = lift.rings_mm_per_s * std::sin(2 * M_PI * 20 * (t - 2)) * std::exp(-(t - 2) / 0.1);
    const auto noise = [&] { return lift.noise_mm_per_s * random.normal(); };
    motion.velocity.push_back({1e-3 * noise(), 1e-3 * noise(), 1e-3 * (speed + noise())});
    motion.acceleration.push_back({});
    motion.known.push_back(true);
  }
  return motion;
}

void expect_move(const MotionCourse& course, double within_ms) {
  const auto moves = course.moves_at(0);
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_NEAR(1e-3 * static_cast<double>(us_of(moves[0].begin)), 1000, within_ms);
  EXPECT_NEAR(1e-3 * static_cast<double>(us_of(moves[0].end)), 2000, within_ms);
}

TEST(MotionCourse, HasTheStartAndTheStopOfALift) { expect_move(MotionCourse(motion_of({})), 8); }

TEST(MotionCourse, FindsASlowLiftInANoisyLog) {
  expect_move(MotionCourse(motion_of({.mm_per_s = 6, .noise_mm_per_s = 0.8})), 30);
}

TEST(MotionCourse, EndsALiftBeforeTheArmRingsOn) { expect_move(MotionCourse(motion_of({.rings_mm_per_s = 1.4})), 12); }

TEST(MotionCourse, IsEmptyWhereTheArmRests) {
  const MotionCourse course(motion_of({.mm_per_s = 0}));
  EXPECT_FALSE(course.moves_at_all());
}

TEST(MotionCourse, BeginsMovesAndStopsInItsBins) {
  const MotionCourse course(motion_of({}));
  const auto conditions = course.conditions(camera_time(5'000'000), 1000us, 3000, 5'000'000);
  const auto start = std::find(conditions.begin(), conditions.end(), arm_starts);
  ASSERT_NE(start, conditions.end());
  EXPECT_NEAR(static_cast<double>(start - conditions.begin()), 1000, 8);
  EXPECT_EQ(conditions[500], arm_still);
  EXPECT_EQ(conditions[1500], 5) << "20 mm/s is nearest to 25";
  EXPECT_EQ(conditions[2030], arm_stopped);
  EXPECT_EQ(conditions[2500], arm_still);
  EXPECT_EQ(course.changes_outside(camera_time(5'000'000), camera_time(8'000'000), 5'000'000), 0);
  EXPECT_EQ(course.changes_outside(camera_time(5'000'000), camera_time(6'500'000), 5'000'000), 1);
  EXPECT_EQ(course.changes_outside(camera_time(5'000'000), camera_time(5'500'000), 5'000'000), 2);
}

/// Moves the arm along z with a speed of 20 mm/s for each of these times [s], upwards if it is positive.
alignment::ArmMotion motion_along_z(const std::vector<double>& moves_s) {
  alignment::ArmMotion motion;
  Random random(4);
  const auto move_for = [&](double seconds, double mm_per_s) {
    for (int i = 0; 0.004 * i < seconds; ++i) {
      const double t = 0.004 * i;
      const double smooth = std::min({1.0, t / 0.02, (seconds - t) / 0.02});
      motion.velocity.push_back({5e-5 * random.normal(), 5e-5 * random.normal(), 1e-3 * smooth * mm_per_s});
      motion.acceleration.push_back({});
      motion.known.push_back(true);
    }
  };
  move_for(1, 0);
  for (const double s : moves_s) move_for(std::abs(s), s > 0 ? 20 : -20);
  move_for(1, 0);
  return motion;
}

TEST(MotionCourse, KnowsASyncTapFromALift) {
  const auto has = [](const std::vector<double>& moves_s, std::uint8_t condition) {
    const auto conditions = MotionCourse(motion_along_z(moves_s)).conditions(camera_time(0), 1000us, 3000, 0);
    return std::find(conditions.begin(), conditions.end(), condition) != conditions.end();
  };
  EXPECT_TRUE(has({-0.3, 0.3}, arm_taps));
  EXPECT_FALSE(has({-0.3, 0.3}, arm_starts));
  EXPECT_FALSE(has({0.3, -0.3}, arm_taps)) << "it goes up and comes back";
  EXPECT_FALSE(has({-0.6, 0.2}, arm_taps)) << "it goes down, and rises a little";
  EXPECT_FALSE(has({-0.6, 0.6}, arm_taps)) << "it takes longer than a second";
  EXPECT_FALSE(has({0.3}, arm_taps));
}

}  // namespace
}  // namespace tactile::labels
