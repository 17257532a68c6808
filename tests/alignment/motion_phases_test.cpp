#include "tactile/alignment/motion_phases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "alignment/made_arm.hpp"
#include "alignment/made_motion.hpp"
#include "tactile/alignment/motion_rows.hpp"
#include "tactile/robot/pose_speeds.hpp"

namespace tactile::alignment {
namespace {

using test::MadeArm;
using test::MadeMotion;

double ms(const robot::RobotLog& log, RobotTime t) { return 1e3 * test::seconds(log, t); }

std::string kinds(const std::vector<MotionPhase>& phases) {
  std::string text;
  for (const MotionPhase& phase : phases) text += (text.empty() ? "" : " ") + std::string(name_of(phase.kind));
  return text;
}

MadeMotion lift(double start_s, double lasts_s, double speed) {
  MadeMotion motion;
  add_move(motion, start_s, lasts_s, speed);
  return motion;
}

TEST(MotionPhases, FindStartAndEndOfALiftBetweenTheRows) {
  for (const double start_s : {1.0, 1.0025, 1.0061}) {
    MadeMotion motion = lift(start_s, 0.5, 0.06);
    motion.noise = 1e-6;
    const robot::RobotLog log = log_of(motion);
    const auto phases = motion_phases(log);
    ASSERT_EQ(kinds(phases), "lift");
    EXPECT_NEAR(ms(log, phases[0].start), 1e3 * start_s, 0.1);
    EXPECT_NEAR(ms(log, phases[0].end), 1e3 * start_s + 500, 0.1);
    EXPECT_NEAR(phases[0].peak_speed, 0.06, 1e-4);
    EXPECT_NEAR(phases[0].height_change, 0.06 * 0.45, 1e-4);
    EXPECT_LT(phases[0].start_sigma_us, 500);
  }
}

struct Ringing {
  ArmRinging ringing;
  double speed;
};

TEST(MotionPhases, OfARingingArmAreAccurateToMillisecondsAtBothRates) {
  int seed = 0;
  for (const int period_ms : {8, 2}) {
    double squares = 0, count = 0;
    for (const ArmRinging& ringing :
         {ArmRinging{12, 0.12, 0.5}, {14, 0.05, 0.3}, {20, 0.1, 0.5}, {28, 0.08, 0.15}, {24, 0.04, 0.4}}) {
      for (const double speed : {0.03, 0.07, 0.12}) {
        for (const double phase_s : {0.0, 0.0031}) {
          MadeMotion motion = lift(1.2 + phase_s, 0.55, speed);
          motion.ringing = ringing;
          motion.period_ms = period_ms;
          motion.noise = 4e-4;
          motion.seed = static_cast<std::uint64_t>(++seed);
          const robot::RobotLog log = log_of(motion);
          const auto phases = motion_phases(log);
          ASSERT_EQ(kinds(phases), "lift") << ringing.hz << " Hz, " << speed << " m/s: the tail is no phase";
          const double start_off = ms(log, phases[0].start) - 1e3 * motion.knots_s.front();
          const double end_off = ms(log, phases[0].end) - 1e3 * motion.knots_s.back();
          EXPECT_NEAR(start_off, 0, 2.0) << ringing.hz << " Hz, " << speed << " m/s";
          EXPECT_NEAR(end_off, 0, 2.0) << ringing.hz << " Hz, " << speed << " m/s";
          squares +=
              std::pow(1e3 * start_off / phases[0].start_sigma_us, 2.0) + std::pow(1e3 * end_off / phases[0].end_sigma_us, 2.0);
          count += 2;
        }
      }
    }
    EXPECT_LT(std::sqrt(squares / count), 1.3) << "sigma is too small at " << period_ms << " ms";
    EXPECT_GT(std::sqrt(squares / count), 0.4) << "sigma is too large at " << period_ms << " ms";
  }
}

TEST(MotionPhases, FromPosesAloneStartNoSooner) {
  // A speed that is made from poses leaves zero ahead of the arm.
  double starts = 0, ends = 0;
  const int draws = 12;
  for (int seed = 0; seed < draws; ++seed) {
    MadeMotion motion = lift(1.2 + 0.0006 * seed, 0.55, 0.07);
    motion.ringing = {18, 0.08, 0.3};
    motion.seed = static_cast<std::uint64_t>(seed);
    robot::RobotLog log = log_of(motion);
    log.smoothed_over = robot::set_speeds_from_poses(log.states);
    const auto phases = motion_phases(log);
    ASSERT_EQ(kinds(phases), "lift");
    EXPECT_NEAR(ms(log, phases[0].start), 1e3 * motion.knots_s.front(), 3.0);
    EXPECT_NEAR(ms(log, phases[0].end), 1e3 * motion.knots_s.back(), 3.0);
    starts += ms(log, phases[0].start) - 1e3 * motion.knots_s.front();
    ends += ms(log, phases[0].end) - 1e3 * motion.knots_s.back();
  }
  EXPECT_NEAR(starts / draws, 0, 0.5);
  EXPECT_NEAR(ends / draws, 0, 0.5);
}

TEST(MotionPhases, DistinguishTapsFromLifts) {
  for (const int period_ms : {8, 2}) {
    MadeMotion motion{.ringing = {.hz = 16, .decay_s = 0.11, .share = 0.45}};
    motion.period_ms = period_ms;
    for (int i = 0; i < 3; ++i) add_tap(motion, 0.5 + 0.45 * i, 0.25, 0.05);
    add_move(motion, 2.2, 0.6, 0.07);
    motion.length_s = 4;
    const robot::RobotLog log = log_of(motion);
    const auto phases = motion_phases(log);
    ASSERT_EQ(kinds(phases), "tap tap tap lift");
    for (std::size_t i = 0; i < 3; ++i) {
      const double start = 500 + 450 * static_cast<double>(i);
      EXPECT_NEAR(ms(log, phases[i].start), start, 2.0);
      EXPECT_NEAR(ms(log, phases[i].end), start + 250, 2.0);
      ASSERT_TRUE(phases[i].turn.has_value());
      EXPECT_NEAR(ms(log, *phases[i].turn), start + 125, 0.8);
      EXPECT_LT(phases[i].turn_sigma_us, 1'000);
      EXPECT_NEAR(phases[i].height_change, 0, 2e-4);
    }
    EXPECT_FALSE(phases[3].turn.has_value());
  }
}

TEST(MotionPhases, OfThereAndBackWithARestAreATapOnlyIfTheRestIsShort) {
  for (const auto& [rest_s, expected] : {std::pair{0.0, "tap"}, {0.07, "tap"}, {0.3, "lower lift"}}) {
    MadeMotion motion;
    add_move(motion, 0.5, 0.3, -0.05);
    add_move(motion, 0.8 + rest_s, 0.3, 0.05);
    motion.length_s = 2;
    EXPECT_EQ(kinds(motion_phases(log_of(motion))), expected) << rest_s;
  }
  MadeMotion up_and_down;
  add_move(up_and_down, 0.5, 0.3, 0.05);
  add_move(up_and_down, 0.8, 0.3, -0.05);
  EXPECT_EQ(kinds(motion_phases(log_of(up_and_down))), "lift lower") << "taps do not begin upwards";
  MadeMotion unequal;
  add_move(unequal, 0.5, 0.3, -0.03);
  add_move(unequal, 0.8, 0.6, 0.05);
  const robot::RobotLog log = log_of(unequal);
  const auto phases = motion_phases(log);
  ASSERT_EQ(kinds(phases), "lower lift") << "it does not come back to where it was";
  EXPECT_NEAR(ms(log, phases[0].end), 800, 2.0);
  EXPECT_EQ(phases[0].end, phases[1].start);
}

TEST(MotionPhases, AreNamedByWhereTheyGo) {
  for (const auto& [direction, expected] : {std::pair{std::array<double, 3>{0, 0, 1}, "lift"},
                                            {{0, 0, -1}, "lower"},
                                            {{0, 1, 0}, "sideways"},
                                            {{-0.6, 0, 0.8}, "lift"},
                                            {{0.8, 0, 0.6}, "sideways"}}) {
    MadeMotion motion = lift(1, 0.5, 0.06);
    motion.direction = direction;
    const auto phases = motion_phases(log_of(motion));
    ASSERT_EQ(kinds(phases), expected);
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(phases[0].displacement[a], direction[a] * 0.027, 1e-3);
  }
}

TEST(MotionPhases, OfALongMotionAreFittedAtTheirEnds) {
  MadeMotion motion = lift(1.003, 5.0, 0.06);
  motion.ringing = {15, 0.1, 0.4};
  motion.length_s = 8;
  const robot::RobotLog log = log_of(motion);
  const auto phases = motion_phases(log);
  ASSERT_EQ(kinds(phases), "lift");
  EXPECT_NEAR(ms(log, phases[0].start), 1003, 1.5);
  EXPECT_NEAR(ms(log, phases[0].end), 6003, 1.5);
  EXPECT_NEAR(phases[0].height_change, 0.06 * 4.95, 1e-3);
}

TEST(MotionPhases, DoNotKnowTheStartOfAnArmThatAlreadyMoved) {
  const robot::RobotLog whole = log_of(lift(1.0, 0.8, 0.06));
  robot::RobotLog late = whole, early = whole, torn = whole;
  std::erase_if(late.states, [&](const robot::RobotState& state) { return ms(whole, state.t) < 1400; });
  std::erase_if(early.states, [&](const robot::RobotState& state) { return ms(whole, state.t) > 1400; });
  std::erase_if(torn.states,
                [&](const robot::RobotState& state) { return ms(whole, state.t) > 1300 && ms(whole, state.t) < 1500; });
  auto phases = motion_phases(late);
  ASSERT_EQ(kinds(phases), "lift");
  EXPECT_TRUE(std::isinf(phases[0].start_sigma_us));
  EXPECT_EQ(phases[0].start, late.states.front().t);
  EXPECT_NEAR(ms(whole, phases[0].end), 1800, 2.0);
  EXPECT_LT(phases[0].end_sigma_us, 2'000);

  phases = motion_phases(early);
  ASSERT_EQ(kinds(phases), "lift");
  EXPECT_TRUE(std::isinf(phases[0].end_sigma_us));
  EXPECT_EQ(phases[0].end, early.states.back().t);
  EXPECT_NEAR(ms(whole, phases[0].start), 1000, 2.0);

  phases = motion_phases(torn);
  ASSERT_EQ(kinds(phases), "lift lift") << "what was in the gap is not known";
  EXPECT_NEAR(ms(whole, phases[0].start), 1000, 2.0);
  EXPECT_TRUE(std::isinf(phases[0].end_sigma_us) && std::isinf(phases[1].start_sigma_us));
  EXPECT_NEAR(ms(whole, phases[1].end), 1800, 2.0);
}

TEST(MotionPhases, OfFewRowsAreStillFound) {
  MadeMotion motion = lift(1.0, 0.5, 0.06);
  motion.period_ms = 40;
  motion.length_s = 2;
  const robot::RobotLog log = log_of(motion);
  const auto phases = motion_phases(log);
  ASSERT_EQ(kinds(phases), "lift");
  EXPECT_NEAR(ms(log, phases[0].start), 1000, std::max(25.0, 3e-3 * phases[0].start_sigma_us));
  EXPECT_NEAR(ms(log, phases[0].end), 1500, std::max(25.0, 3e-3 * phases[0].end_sigma_us));
}

TEST(MotionPhases, OfARestingArmAreNone) {
  MadeMotion resting;
  EXPECT_TRUE(motion_phases(log_of(resting)).empty());
  resting.noise = 0;
  EXPECT_TRUE(motion_phases(log_of(resting)).empty());
  EXPECT_TRUE(motion_phases({}).empty());
  robot::RobotLog one;
  one.states.emplace_back();
  one.states[0].tcp_speed[2] = 1;
  EXPECT_TRUE(motion_phases(one).empty());
}

TEST(MotionPhases, FindALiftsStartThroughItsRinging) {
  for (const double share : {0.0, 0.2, 0.45}) {
    for (const double hz : {13.0, 19.0, 27.0}) {
      MadeArm arm;
      arm.ringing_share = share;
      arm.ringing_hz = hz;
      arm.lift(1.2345, 0.7, 0.08);
      const auto phases = motion_phases(arm.log(0, 3));
      ASSERT_EQ(kinds(phases), "lift");
      EXPECT_NEAR(1e-3 * static_cast<double>(us_of(phases[0].start)), 1234.5, 1.2) << share << " at " << hz << " Hz";
      EXPECT_NEAR(1e-3 * static_cast<double>(us_of(phases[0].end)), 1934.5, 1.5);
      EXPECT_LT(phases[0].start_sigma_us, 1'000);
      ASSERT_TRUE(phases[0].profile);
      EXPECT_NEAR(phases[0].profile->commanded_at(0.35)[2], 0.08, 0.002);
      EXPECT_EQ(phases[0].profile->rings(), share > 0) << share << " at " << hz << " Hz";
    }
  }
}

TEST(MotionPhases, HaveAProfileFromTheirStartOn) {
  MadeMotion motion = lift(1.0, 0.5, 0.06);
  motion.ringing = {18, 0.08, 0.3};
  add_tap(motion, 2.0, 0.25, 0.05);
  add_move(motion, 3.0, 0.3, -0.05);  // a tap of two stretches
  add_move(motion, 3.37, 0.3, 0.05);
  add_move(motion, 4.5, 4.0, 0.06);  // fitted at its ends
  motion.length_s = 9.5;
  const auto phases = motion_phases(log_of(motion));
  ASSERT_EQ(kinds(phases), "lift tap tap lift");
  for (const MotionPhase& phase : phases) {
    ASSERT_TRUE(phase.profile) << name_of(phase.kind);
    EXPECT_TRUE(phase.is_whole());
    const double start_s = 1e-6 * static_cast<double>(us_of(phase.start) - 1'000'000'000);
    const double lasts_s = 1e-6 * static_cast<double>((phase.end - phase.start).count());
    EXPECT_NEAR(phase.profile->knots_s.front(), 0.0, 1e-6);
    EXPECT_NEAR(phase.profile->knots_s.back(), lasts_s, 1e-6);
    for (double since_s = 0; since_s < lasts_s; since_s += 0.01)
      EXPECT_NEAR(phase.profile->commanded_at(since_s)[2], commanded(motion, start_s + since_s), 0.004) << since_s;
  }
}

TEST(MotionPhases, HoldNearTheEndsOfTime) {
  MadeArm arm;
  arm.lift(1.0, 0.6, 0.06);
  const std::int64_t zero = std::numeric_limits<std::int64_t>::max() - 5'000'000;
  const auto phases = motion_phases(arm.log(0, 3, zero));
  ASSERT_EQ(phases.size(), 1U);
  EXPECT_NEAR(static_cast<double>(us_of(phases[0].start) - zero), 1e6, 1'200);
}

TEST(SpeedNoise, IsThatOfARestingArmThoughItMoves) {
  MadeMotion motion = lift(0.5, 3.0, 0.06);
  motion.noise = 4e-4;
  EXPECT_NEAR(speed_noise(log_of(motion)), 4e-4, 0.4e-4);
  EXPECT_EQ(speed_noise({}), 0.0);
}

}  // namespace
}  // namespace tactile::alignment
