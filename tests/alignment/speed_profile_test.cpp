#include "tactile/alignment/speed_profile.hpp"

#include <gtest/gtest.h>

#include "alignment/made_motion.hpp"

namespace tactile::alignment {
namespace {

std::vector<SpeedRow> rows_of(const robot::RobotLog& log, double from_s, double to_s) {
  std::vector<SpeedRow> rows;
  for (const robot::RobotState& state : log.states) {
    const double t_s = test::seconds(log, state.t);
    if (t_s >= from_s && t_s < to_s)
      rows.push_back({.t_s = t_s, .speed = {state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]}});
  }
  return rows;
}

TEST(SpeedProfile, FindsKnotsSpeedsAndRinging) {
  test::MadeMotion motion{.ringing = {.hz = 17, .decay_s = 0.09, .share = 0.4}, .direction = {0.6, 0, 0.8}};
  add_move(motion, 1.0033, 0.6, 0.08);
  const auto rows = rows_of(log_of(motion), 0.85, 1.95);
  const auto profile = fit_speed_profile(rows, {.noise = 3e-4, .knots_s = {0.99, 1.08, 1.53, 1.62}});
  ASSERT_TRUE(profile.has_value());
  ASSERT_EQ(profile->knots_s.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(profile->knots_s[k], motion.knots_s[k], 0.0015);
    EXPECT_GT(profile->sigma_s(k), 1e-5);
    EXPECT_LT(profile->sigma_s(k), 1e-3);
    EXPECT_NEAR(profile->speeds[k][0], 0.6 * motion.speeds[k], 1e-3);
    EXPECT_NEAR(profile->speeds[k][2], 0.8 * motion.speeds[k], 1e-3);
  }
  EXPECT_NEAR(profile->ringing.hz, 17, 0.5);
  EXPECT_NEAR(profile->ringing.decay_s, 0.09, 0.02);
  EXPECT_NEAR(profile->ringing.share, 0.4, 0.08);
  EXPECT_NEAR(profile->speed_sigma, 3e-4, 1e-4);
  for (const SpeedRow& row : rows) {
    const auto commanded = profile->commanded_at(row.t_s), ringing = profile->ringing_at(row.t_s);
    EXPECT_NEAR(commanded[2] + ringing[2], row.speed[2], 0.003) << row.t_s;
  }
}

TEST(SpeedProfile, GivesTheStandardDeviationOfAKnot) {
  // Over many draws of the noise the error is what is reported.
  double squares = 0;
  const int draws = 60;
  for (int seed = 0; seed < draws; ++seed) {
    test::MadeMotion motion{
        .ringing = {.hz = 20, .decay_s = 0.08, .share = 0.3}, .noise = 5e-4, .seed = 100 + static_cast<std::uint64_t>(seed)};
    add_move(motion, 0.301, 0.5, 0.06);
    motion.length_s = 1.3;
    const auto profile =
        fit_speed_profile(rows_of(log_of(motion), 0.15, 1.15), {.noise = 5e-4, .knots_s = {0.3, 0.35, 0.75, 0.8}});
    ASSERT_TRUE(profile.has_value());
    squares += std::pow((profile->knots_s.front() - 0.301) / profile->sigma_s(0), 2.0);
  }
  EXPECT_GT(std::sqrt(squares / draws), 0.5);
  EXPECT_LT(std::sqrt(squares / draws), 1.5);
}

TEST(SpeedProfile, AddsTheKnotsThatTheRowsNeed) {
  test::MadeMotion motion{.knots_s = {0.3, 0.35, 0.6, 0.64, 0.9, 0.95}, .speeds = {0, 0.06, 0.06, 0.11, 0.11, 0}};
  motion.length_s = 1.4;
  const auto profile = fit_speed_profile(rows_of(log_of(motion), 0.1, 1.3), {.noise = 3e-4, .knots_s = {0.3, 0.38, 0.9, 0.95}});
  ASSERT_TRUE(profile.has_value());
  EXPECT_GE(profile->knots_s.size(), 6U);
  EXPECT_NEAR(profile->knots_s.front(), 0.3, 0.002);
  EXPECT_NEAR(profile->knots_s.back(), 0.95, 0.002);
  for (const auto& [t_s, speed] : {std::pair{0.5, 0.06}, {0.62, 0.085}, {0.8, 0.11}})
    EXPECT_NEAR(profile->commanded_at(t_s)[2], speed, 0.003);
}

TEST(SpeedProfile, IsRobustAgainstARowOfAnotherPackage) {
  test::MadeMotion motion;
  add_move(motion, 0.302, 0.5, 0.08);
  motion.length_s = 1.2;
  auto rows = rows_of(log_of(motion), 0.1, 1.1);
  const auto on_ramp = std::find_if(rows.begin(), rows.end(), [](const SpeedRow& row) { return row.t_s > 0.33; });
  on_ramp->speed = (on_ramp + 1)->speed;
  const auto profile = fit_speed_profile(rows, {.noise = 3e-4, .knots_s = {0.3, 0.37, 0.74, 0.8}});
  ASSERT_TRUE(profile.has_value());
  EXPECT_EQ(profile->knots_s.size(), 4U);
  EXPECT_NEAR(profile->knots_s.front(), 0.302, 0.0015);
}

TEST(SpeedProfile, OfAnOpenEndFitsTheOtherEnd) {
  test::MadeMotion motion{.ringing = {.hz = 22, .decay_s = 0.06, .share = 0.3}};
  add_move(motion, 0.302, 3.0, 0.08);
  const robot::RobotLog log = log_of(motion);
  const auto start = fit_speed_profile(rows_of(log, 0.15, 0.75), {.noise = 3e-4, .knots_s = {0.3, 0.37, 0.75}, .open_end = true});
  ASSERT_TRUE(start.has_value());
  EXPECT_NEAR(start->knots_s.front(), 0.302, 0.001);
  EXPECT_EQ(start->sigma_s(2), 0.0);
  const auto end = fit_speed_profile(rows_of(log, 2.8, 3.6), {.noise = 3e-4, .knots_s = {2.8, 3.24, 3.3}, .open_begin = true});
  ASSERT_TRUE(end.has_value());
  EXPECT_NEAR(end->knots_s.back(), 3.302, 0.001);
}

TEST(SpeedProfile, NeedsRows) {
  EXPECT_FALSE(fit_speed_profile({}, {.knots_s = {0, 1, 2, 3}}).has_value());
  std::vector<SpeedRow> rows;
  for (int i = 0; i < 9; ++i) rows.push_back({.t_s = 0.008 * i, .speed = {0, 0, 0.01}});
  EXPECT_FALSE(fit_speed_profile(rows, {.knots_s = {0, 0.01, 0.02, 0.03}}).has_value());
}

}  // namespace
}  // namespace tactile::alignment
