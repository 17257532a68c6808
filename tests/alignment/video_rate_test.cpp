#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tactile/alignment/video_clock.hpp"

namespace tactile::alignment {
namespace {

/// Ten seconds of a film whose times are index / 25.
MotionEnergy counted_at_25() {
  MotionEnergy energy;
  energy.median_step = 40ms;
  energy.steps.reserve(250);
  for (VideoTime t{}; t < VideoTime{10s}; t += 40ms) energy.steps.push_back({.begin = t, .end = t + 40ms});
  return energy;
}

/// A motion of the arm, by the counted times and truly, in seconds.
ClockAnchor motion(double counted_s, double truly_s) {
  return {.clock_us = std::llround(1e6 * counted_s), .camera = camera_time(std::llround(1e6 * truly_s)), .sigma_us = 3'000};
}

VideoClockFit fit_of(const std::vector<ClockAnchor>& motions) {
  VideoClockFit fit;
  fit.anchors = motions;
  return with_clock(fit, counted_at_25());
}

TEST(VideoRate, ThatTwoMotionsContradictIsRefused) {
  // Taken at 30 frames/s: each second counts as 1.2 s. The first motion is the better one, which alone would give a clock.
  std::vector<ClockAnchor> motions{motion(2.4, 2), motion(3, 2.5)};
  motions[1].sigma_us = 6'000;
  const VideoClockFit fit = fit_of(motions);
  EXPECT_FALSE(fit.clock);
  EXPECT_EQ(
      fit.refused,
      "the times of the film are even: they count 25 frames/s, but by the distance of its motions it has about 30 frames/s; "
      "expected times of the film's own rate");
}

TEST(VideoRate, ThatThreeMotionsContradictIsRefused) {
  EXPECT_NE(fit_of({motion(1.8, 1.5), motion(2.4, 2), motion(3, 2.5)}).refused.find("about 30 frames/s"), std::string::npos);
}

TEST(VideoRate, ThatTwoMotionsShowNeedsNoRemark) {
  const VideoClockFit fit = fit_of({motion(2, 2), motion(4, 4.02)});
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_TRUE(fit.remark.starts_with("the times of the film are even")) << fit.remark;
  EXPECT_EQ(fit.remark.find("frames/s"), std::string::npos) << fit.remark;
}

TEST(VideoRate, IsNotKnownFromOneMotion) {
  const VideoClockFit fit = fit_of({motion(2.4, 2)});
  ASSERT_TRUE(fit.clock) << fit.refused;
  EXPECT_TRUE(fit.remark.ends_with(", or by more if the film was not taken at 25 frames/s: its motions do not show its rate"))
      << fit.remark;
}

}  // namespace
}  // namespace tactile::alignment
