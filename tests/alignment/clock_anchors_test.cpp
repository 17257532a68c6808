#include "tactile/alignment/clock_anchors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "alignment/made_arm.hpp"
#include "tactile/core/random.hpp"

namespace tactile::alignment {
namespace {

using test::MadeArm;

constexpr std::int64_t camera_zero_us = 1'700'000'000'000'000;  // of the arm's time
constexpr std::int64_t robot_zero_us = 5'432'100'000;

/// What the camera's inertial sensor feels, turned some way against the arm's base.
std::vector<events::ImuSample> felt_by(const MadeArm& arm, double from_s, double to_s, std::int64_t zero_us = camera_zero_us) {
  Random random(8);
  std::vector<events::ImuSample> samples;
  for (double t = from_s; t < to_s; t += 0.001242) {  // NOLINT(clang-analyzer-security.FloatLoopCounter)
    const double up_g = 1.0 + arm.acceleration(t) / 9.80665;
    events::ImuSample sample;
    sample.t = camera_time(zero_us + std::llround(1e6 * t) / 200 * 200);
    const double axes[3] = {0.3 * up_g, -0.9 * up_g, 0.316 * up_g};
    for (std::size_t k = 0; k < 3; ++k) sample.acceleration_g[k] = static_cast<float>(axes[k] + 0.01 + 0.003 * random.normal());
    samples.push_back(sample);
  }
  return samples;
}

/// A Poisson event rate: `per_ms(t)` events in a millisecond of the arm's time.
EventRate rate_of(double from_s, double to_s, const std::function<double(double)>& per_ms,
                  std::int64_t zero_us = camera_zero_us) {
  Random random(4);
  EventRate rate{.begin = camera_time(zero_us + std::llround(1e6 * from_s)),
                 .bin = 200us,
                 .counts = {},
                 .hot_pixels = 0,
                 .last = {},
                 .hot = {}};
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter)
  for (double t = from_s; t < to_s; t += 0.0002)
    rate.counts.push_back(static_cast<std::uint32_t>(random.poisson(0.2 * per_ms(t))));
  rate.last = rate.begin_of(rate.counts.size());
  return rate;
}

constexpr double quiet_per_ms = 15;

/// A slip: nothing until the slack is used up, then events in step with the speed, less from when the tips let go.
double slip_per_ms(const MadeArm& arm, double t, double start_s, double end_s, double slack_s, double drag_s) {
  if (t < start_s + slack_s || t > end_s) return 0.0;
  const double v = arm.commanded_speed(t);
  return (t < start_s + slack_s + drag_s ? 40'000 : 8'000) * v;
}

FoundAnchors anchors_of(const robot::RobotLog& log, const EventRate& rate, std::span<const events::ImuSample> imu = {},
                        std::span<const CameraArrival> arrivals = {}, std::optional<CoarseOffset> coarse = {}) {
  const std::vector<MotionPhase> motions = motion_phases(log);
  return clock_anchors({.robot = log,
                        .motions = motions,
                        .rate = rate,
                        .quiet = quiet_rate(rate),
                        .imu = imu,
                        .host_from_camera = arrivals,
                        .coarse = coarse});
}

struct Session {
  robot::RobotLog log;
  EventRate rate;
  std::vector<events::ImuSample> imu;

  FoundAnchors anchors(std::optional<CoarseOffset> coarse = {}) const { return anchors_of(log, rate, imu, {}, coarse); }
};

double error_ms(const ClockAnchor& anchor, std::int64_t camera_us = camera_zero_us, std::int64_t robot_us = robot_zero_us) {
  return 1e-3 * static_cast<double>((us_of(anchor.camera) - camera_us) - (anchor.clock_us - robot_us));
}

const ClockAnchor* first_of(const FoundAnchors& found, AnchorKind kind) {
  for (const ClockAnchor& anchor : found.anchors) {
    if (anchor.kind == kind) return &anchor;
  }
  return nullptr;
}

std::size_t count_of(const FoundAnchors& found, AnchorKind kind) {
  std::size_t count = 0;
  for (const ClockAnchor& anchor : found.anchors) count += anchor.kind == kind ? 1 : 0;
  return count;
}

bool says(const FoundAnchors& found, const std::string& words) {
  for (const Doubt& doubt : found.doubts) {
    if (doubt.words.find(words) != std::string::npos) return true;
  }
  return false;
}

/// A press at 1 s, a lift at `lift_s`; without an IMU.
Session press_and_slip(const MadeArm& arm, double lift_s, double lift_lasts_s, double slack_s, double log_from_s,
                       double log_to_s) {
  Session session;
  session.log = arm.log(log_from_s, log_to_s, robot_zero_us);
  session.rate = rate_of(0, 4.5, [&](double t) {
    const double press = t > 1.0 && t < 1.3 ? 250 * (1.3 - t) / 0.3 : 0.0;
    return quiet_per_ms + press + slip_per_ms(arm, t, lift_s, lift_s + lift_lasts_s, slack_s, 0.02);
  });
  return session;
}

EventRate quiet_recording(double to_s) {
  return rate_of(0, to_s, [](double) { return quiet_per_ms; });
}

TEST(ClockAnchors, ImuAgainstTheLogWithoutAnyKnownOffset) {
  MadeArm arm;
  arm.ringing_share = 0.3;
  arm.lift(2.1, 0.7, 0.09);
  Session session{.log = arm.log(-0.7, 4.8, robot_zero_us), .rate = quiet_recording(4.5), .imu = felt_by(arm, 0, 4.5)};
  const FoundAnchors found = session.anchors();
  ASSERT_EQ(count_of(found, AnchorKind::imu), 1U);
  EXPECT_NEAR(error_ms(*first_of(found, AnchorKind::imu)), 0.0, 1.0);
  EXPECT_LT(first_of(found, AnchorKind::imu)->sigma_us, 1'000);
  ASSERT_TRUE(found.imu);
  EXPECT_GT(found.imu->likeness, 0.8);
  EXPECT_GT(found.imu->ratio, 1.5);
}

TEST(ClockAnchors, ImuAnchorsOfALongRunMeasureTheDrift) {
  MadeArm arm;
  Random random(2);
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter)
  for (double t = 5; t < 150; t += random.uniform(9, 20)) arm.lift(t, random.uniform(0.5, 0.9), random.uniform(0.04, 0.1));
  // A controller that is fast by 120 ppm: the camera's time runs slower than its clock.
  Session session{.log = arm.log(-1, 161, robot_zero_us, 120), .rate = quiet_recording(160), .imu = felt_by(arm, 0, 160)};
  const FoundAnchors found = session.anchors();
  ASSERT_GE(count_of(found, AnchorKind::imu), 8U);
  const ClockFit fit = fit_clock(found.anchors, robot_zero_us);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_NEAR(fit.clock->relation.drift_ppm, -120.0, 8.0);
  EXPECT_NEAR(static_cast<double>(fit.clock->relation.offset_us - (camera_zero_us - robot_zero_us)), 0.0, 1'000.0);
}

TEST(ClockAnchors, EqualLiftsAtEvenStepsAreAmbiguous) {
  MadeArm arm;
  for (int i = 0; i < 12; ++i) arm.lift(2.0 + 3.0 * i, 0.7, 0.08);
  // The camera sees four of the twelve.
  Session session{.log = arm.log(0, 40, robot_zero_us), .rate = quiet_recording(12), .imu = felt_by(arm, 13, 25)};
  session.rate.begin = session.imu.front().t;
  const FoundAnchors found = session.anchors();
  EXPECT_EQ(count_of(found, AnchorKind::imu), 0U);
  EXPECT_TRUE(says(found, "ambiguous"));
  // Roughly known clocks settle it.
  const FoundAnchors settled = session.anchors(CoarseOffset{camera_zero_us - robot_zero_us + 300'000, 1s});
  ASSERT_GE(count_of(settled, AnchorKind::imu), 3U);
  EXPECT_NEAR(error_ms(*first_of(settled, AnchorKind::imu)), 0.0, 1.0);
}

TEST(ClockAnchors, AnImuWithAnotherMotionIsRefused) {
  MadeArm arm, other;
  arm.lift(2.1, 0.7, 0.09);
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter)
  for (double t = 0.2; t < 4; t += 0.11) other.tap(t, 0.1, 0.002);
  Session session{.log = arm.log(0, 4.8, robot_zero_us), .rate = quiet_recording(4.5), .imu = felt_by(other, 0, 4.5)};
  const FoundAnchors found = session.anchors();
  EXPECT_EQ(count_of(found, AnchorKind::imu), 0U);
  EXPECT_FALSE(found.doubts.empty());
}

TEST(ClockAnchors, TheFirstShearGivesTheArmsStartForAnySlack) {
  for (const double slack_s : {0.004, 0.010, 0.018}) {
    MadeArm arm;
    arm.ringing_share = 0.25;
    arm.lift(2.4, 0.7, 0.08);
    const Session session = press_and_slip(arm, 2.4, 0.7, slack_s, -0.9, 4.9);
    const FoundAnchors found = session.anchors();
    const ClockAnchor* shear = first_of(found, AnchorKind::first_shear);
    ASSERT_NE(shear, nullptr) << slack_s;
    EXPECT_NEAR(error_ms(*shear), 0.0, 3.0) << "the slack of " << 1e3 * slack_s << " ms is no part of it";
    EXPECT_LT(std::abs(error_ms(*shear)), 1.96e-3 * std::hypot(shear->sigma_us, shear->bias_us));
  }
}

TEST(ClockAnchors, AShearWithoutAShapeIsPlacedByItsOnsetAndWide) {
  MadeArm arm;
  arm.lift(2.4, 0.7, 0.08);
  Session session = press_and_slip(arm, 2.4, 0.7, 0.01, -0.9, 4.9);
  session.rate = rate_of(0, 4.5, [](double t) { return quiet_per_ms + (t > 2.41 && t < 3.1 ? 120.0 : 0.0); });
  const FoundAnchors found = session.anchors();
  const ClockAnchor* shear = first_of(found, AnchorKind::first_shear);
  ASSERT_NE(shear, nullptr);
  EXPECT_GT(shear->bias_us, 5'000) << "all lifts of a mount have its slack";
  EXPECT_LT(std::abs(error_ms(*shear)), 1.96e-3 * std::hypot(shear->sigma_us, shear->bias_us));
}

/// Two slips that fit the lift equally, the true one at 2.4 s and another 1.3 s before it; and a press at `press_s`.
FoundAnchors anchors_of_two_slips(double press_s) {
  MadeArm arm;
  arm.lift(2.4, 0.7, 0.08);
  Session session = press_and_slip(arm, 2.4, 0.7, 0.01, -0.9, 5.9);
  session.rate = rate_of(0, 5.5, [&](double t) {
    const double press = t > press_s && t < press_s + 0.1 ? 150.0 : 0.0;
    return quiet_per_ms + press + slip_per_ms(arm, t, 2.4, 3.1, 0.01, 0.02) + slip_per_ms(arm, t + 1.3, 2.4, 3.1, 0.01, 0.02);
  });
  return session.anchors();
}

TEST(ClockAnchors, TwoBurstsThatFitTheLiftEquallyAreAmbiguous) {
  const FoundAnchors found = anchors_of_two_slips(0.5);
  EXPECT_TRUE(found.anchors.empty());
  EXPECT_TRUE(says(found, "ambiguous"));
  ASSERT_TRUE(found.events);
  EXPECT_LT(found.events->ratio, 1.2);
}

TEST(ClockAnchors, ALiftFollowsAPress) {
  const FoundAnchors found = anchors_of_two_slips(-1.0);
  const ClockAnchor* shear = first_of(found, AnchorKind::first_shear);
  ASSERT_NE(shear, nullptr) << "nothing was held when the first burst began";
  EXPECT_NEAR(error_ms(*shear), 0.0, 5.0);
}

TEST(ClockAnchors, APressIsNoLiftThatTheSkinShowsHardlyAnythingOf) {
  // The press looks like a shear. That of the lift is short, and falls into the lift that would begin with the press.
  MadeArm arm;
  arm.lift(2.2, 1.4, 0.08);
  const robot::RobotLog log = arm.log(-0.9, 5.9, robot_zero_us);
  const EventRate rate = rate_of(0, 5.5, [&](double t) {
    const double press = slip_per_ms(arm, t + 1.2, 2.2, 2.5, 0.01, 0.02);
    return quiet_per_ms + press + slip_per_ms(arm, t, 2.2, 2.25, 0.01, 0.02);
  });
  const FoundAnchors found = anchors_of(log, rate);
  EXPECT_EQ(first_of(found, AnchorKind::first_shear), nullptr);
  EXPECT_TRUE(says(found, "may be a press")) << (found.doubts.empty() ? "" : found.doubts[0].words);
}

TEST(ClockAnchors, AnImuThatLeavesTwoTimesForbidsAThird) {
  // The arm moves twice alike, out of contact the second time, so the IMU matches at two lags; the skin moves as in a lift 1 s
  // later.
  MadeArm arm;
  arm.lift(2.4, 0.7, 0.08);
  MadeArm felt = arm;
  felt.lift(6.4, 0.7, 0.08);
  Session session = press_and_slip(arm, 2.4, 0.7, 0.01, -0.9, 4.0);
  session.imu = felt_by(felt, 0, 9.0);
  const auto rate_with_slip_at = [&](double slip_s) {
    return rate_of(0, 9.0, [&, slip_s](double t) {
      return quiet_per_ms + (t > 1.0 && t < 1.1 ? 150.0 : 0.0) + slip_per_ms(arm, t - (slip_s - 2.4), 2.4, 3.1, 0.01, 0.02);
    });
  };
  session.rate = rate_with_slip_at(2.4);
  const FoundAnchors agrees = session.anchors();
  EXPECT_TRUE(says(agrees, "arm and IMU is ambiguous"));
  ASSERT_NE(first_of(agrees, AnchorKind::first_shear), nullptr);
  EXPECT_NEAR(error_ms(*first_of(agrees, AnchorKind::first_shear)), 0.0, 5.0);
  ASSERT_NE(first_of(agrees, AnchorKind::imu), nullptr) << "the skin decides which of the two it is";
  EXPECT_NEAR(error_ms(*first_of(agrees, AnchorKind::imu)), 0.0, 1.0);
  EXPECT_TRUE(agrees.contradictions.empty());
  session.rate = rate_with_slip_at(3.4);
  EXPECT_TRUE(session.anchors().anchors.empty());
}

TEST(ClockAnchors, AnImuThatFeltAnotherLiftContradictsTheLog) {
  MadeArm arm, felt;
  arm.lift(2.4, 0.7, 0.08);
  felt.lift(2.4, 1.1, 0.05);
  Session session = press_and_slip(arm, 2.4, 0.7, 0.01, -0.9, 4.0);
  session.imu = felt_by(arm, 0, 4.5);
  EXPECT_TRUE(session.anchors().contradictions.empty());
  session.imu = felt_by(felt, 0, 4.5);
  const FoundAnchors found = session.anchors();
  ASSERT_EQ(found.contradictions.size(), 1U);
  EXPECT_EQ(found.contradictions[0].key, "imu-unlike-arm");
  EXPECT_EQ(first_of(found, AnchorKind::imu), nullptr);
  session.imu = felt_by(felt, 0, 3.0);
  EXPECT_TRUE(session.anchors().contradictions.empty()) << "its samples end within the motion: they say nothing of it";
}

TEST(ClockAnchors, AnImuMatchesAnArmThatSpeedsUpSlowly) {
  MadeArm arm;
  arm.lift(2.4, 1.5, 0.04, 0.15);
  Session session{.log = arm.log(-0.9, 5.9, robot_zero_us), .rate = quiet_recording(5.5), .imu = felt_by(arm, 0, 5.5)};
  const FoundAnchors found = session.anchors();
  const ClockAnchor* imu = first_of(found, AnchorKind::imu);
  ASSERT_NE(imu, nullptr) << (found.doubts.empty() ? "" : found.doubts.front().words);
  EXPECT_LT(std::abs(error_ms(*imu)), 1.96e-3 * std::hypot(imu->sigma_us, imu->bias_us));
}

TEST(ClockAnchors, TapsArePlacedByTheirLowestPoint) {
  MadeArm arm;
  arm.ringing_share = 0.2;
  const std::vector<double> starts{1.0, 1.5, 2.2, 66.0, 66.45, 67.1};
  for (const double start : starts) arm.tap(start, 0.25, 0.003);
  Session session;
  session.log = arm.log(-0.6, 69, robot_zero_us, -80);
  session.rate = rate_of(0, 68.5, [&](double t) {
    for (const double start : starts) {
      const double since = t - (start + 0.125);
      if (std::abs(since) > 0.035 || (since > 0 && since < 0.01)) continue;  // pixels that turn back are silent at first
      return quiet_per_ms + 9'000 * std::abs(arm.commanded_speed(t));
    }
    return quiet_per_ms;
  });
  const FoundAnchors found = session.anchors();
  ASSERT_EQ(count_of(found, AnchorKind::sync_tap), 6U);
  const ClockFit fit = fit_clock(found.anchors, robot_zero_us);
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_NEAR(fit.clock->relation.drift_ppm, 80.0, 25.0) << "taps a minute apart show the drift";
  EXPECT_NEAR(static_cast<double>(fit.clock->relation.offset_us - (camera_zero_us - robot_zero_us)), 0.0, 1'500.0);
}

TEST(ClockAnchors, ARestingArmLeavesTheStagesCommands) {
  Session session;
  session.log = MadeArm{}.log(-0.5, 4.9, robot_zero_us);
  session.rate = rate_of(
      0, 4.5, [](double t) { return quiet_per_ms + (t > 1.25 && t < 1.5 ? 200.0 : 0.0) + (t > 2.8 && t < 2.95 ? 150.0 : 0.0); });
  FoundAnchors found = session.anchors();
  EXPECT_TRUE(found.anchors.empty());
  EXPECT_TRUE(says(found, "the arm does not move"));

  const auto at = [](double s) { return RobotTime{microseconds{robot_zero_us + std::llround(1e6 * s)}}; };
  session.log.output_changes = {{"digital output 0", 0, 1, at(0.996), at(1.004)},
                                {"digital output 0", 1, 0, at(2.791), at(2.799)}};
  found = session.anchors();
  ASSERT_EQ(count_of(found, AnchorKind::stage_output), 2U);
  EXPECT_LT(std::abs(error_ms(found.anchors[0])), 300.0);
  EXPECT_GT(found.anchors[0].sigma_us, 100'000) << "how far the stage travels is not known";
  EXPECT_NEAR(error_ms(found.anchors[1]), -25.0, 15.0) << "what opens is seen soon: 30 ms after the command, give or take 100";
  const ClockFit fit = fit_clock(found.anchors, robot_zero_us);
  ASSERT_TRUE(fit.clock);
  EXPECT_LT(fit.clock->offset_high_us - fit.clock->offset_low_us, 240'000);
  EXPECT_LT(fit.clock->offset_low_us, camera_zero_us - robot_zero_us);
  EXPECT_GT(fit.clock->offset_high_us, camera_zero_us - robot_zero_us);
}

TEST(ClockAnchors, HostTimesOfBothDevices) {
  MadeArm arm;
  arm.lift(2.4, 0.7, 0.08);
  Session session = press_and_slip(arm, 2.4, 0.7, 0.01, -0.9, 4.9);
  Random random(6);
  constexpr std::int64_t host_zero_us = 1'800'000'000'000'000;
  for (robot::RobotState& state : session.log.states)
    state.host_time = HostTime{
        microseconds{us_of(state.t) - robot_zero_us + host_zero_us + 1'500 + std::llround(4'000 * random.exponential())}};
  std::vector<CameraArrival> arrivals;
  for (int i = 0; i < 40; ++i) {
    const std::int64_t t = 100'000LL * i;
    arrivals.push_back({camera_time(camera_zero_us + t),
                        HostTime{microseconds{host_zero_us + t + 3'000 + std::llround(5'000 * random.exponential())}}});
  }
  const FoundAnchors found = anchors_of(session.log, session.rate, {}, arrivals);
  ASSERT_GE(count_of(found, AnchorKind::host_time), 1U);
  for (const ClockAnchor& anchor : found.anchors) {
    if (anchor.kind != AnchorKind::host_time) continue;
    EXPECT_NEAR(error_ms(anchor), 0.0, 6.0);
    EXPECT_GT(anchor.bias_us, 2'000);
  }
  ASSERT_EQ(count_of(found, AnchorKind::first_shear), 1U) << "content continues from there";
}

TEST(ClockAnchors, EachPieceOfARestartedControllerHasItsOwn) {
  MadeArm arm;
  arm.lift(2.4, 0.7, 0.08);
  arm.lift(8.0, 0.6, 0.06);
  const std::vector<events::ImuSample> imu = felt_by(arm, 0, 10);
  EventRate rate = quiet_recording(10);
  const robot::RobotLog before = arm.log(-0.5, 5, robot_zero_us), after = arm.log(6, 10.5, -6'000'000 + 900'000);
  const FoundAnchors first = anchors_of(before, rate, imu);
  const FoundAnchors second = anchors_of(after, rate, imu);
  ASSERT_EQ(count_of(first, AnchorKind::imu), 1U);
  ASSERT_EQ(count_of(second, AnchorKind::imu), 1U);
  EXPECT_NEAR(error_ms(first.anchors.back()), 0.0, 1.0);
  EXPECT_NEAR(error_ms(second.anchors.back(), camera_zero_us, -6'000'000 + 900'000), 0.0, 1.0);
}

TEST(ClockAnchors, HoldAtTheEndsOfTime) {
  MadeArm arm;
  arm.lift(2.1, 0.7, 0.09);
  for (const std::int64_t camera_us :
       {std::numeric_limits<std::int64_t>::max() - 5'000'000, std::numeric_limits<std::int64_t>::min() + 100}) {
    const std::int64_t robot_us = camera_us > 0 ? robot_zero_us : -robot_zero_us;
    const robot::RobotLog log = arm.log(0, 4.5, robot_us);
    const std::vector<events::ImuSample> imu = felt_by(arm, 0, 4.5, camera_us);
    const EventRate rate = rate_of(
        0, 4.5, [](double) { return quiet_per_ms; }, camera_us);
    const FoundAnchors found = anchors_of(log, rate, imu);
    ASSERT_EQ(count_of(found, AnchorKind::imu), 1U);
    EXPECT_NEAR(error_ms(*first_of(found, AnchorKind::imu), camera_us, robot_us), 0.0, 1.0);
  }
  const EventRate rate = rate_of(
      0, 1, [](double) { return quiet_per_ms; }, std::numeric_limits<std::int64_t>::min() + 100);
  const robot::RobotLog log = arm.log(0, 4.5, std::numeric_limits<std::int64_t>::max() - 10'000'000);
  EXPECT_TRUE(says(anchors_of(log, rate), "further apart than 64 bits"));
}

TEST(ClockAnchors, WithoutAMatchADoubtGivesTheReason) {
  const EventRate rate = quiet_recording(2);
  EXPECT_FALSE(anchors_of(robot::RobotLog{}, rate).doubts.empty());
  MadeArm arm;
  arm.lift(1.0, 0.5, 0.05);
  const FoundAnchors found = anchors_of(arm.log(0, 2), rate);
  EXPECT_TRUE(found.anchors.empty());
  EXPECT_TRUE(says(found, "no activity of the skin"));
}

}  // namespace
}  // namespace tactile::alignment
