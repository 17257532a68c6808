#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tactile/simulation/skin_motion.hpp"

namespace tactile::simulation {

inline constexpr double dt_s = 200e-6;
inline constexpr SkinView view;

/// Every marker is touched at once, pushed straight, and dragged along the image's y axis.
inline RunPlan plain_plan() {
  RunPlan plan;
  PressPlan press;
  press.contact_s = 0.10005;
  press.press_s = 0.2;
  press.depth_mm = 1.0;
  press.press_power = 1.0;
  plan.presses = {press};
  plan.lift.emplace();
  plan.lift->start_s = 0.5;
  plan.lift->lift_s = 0.4;
  plan.lift->speed_mm_s = 60.0;
  plan.lift->acceleration_mm_s2 = 1200.0;
  plan.lift->slack_mm = 0.06;
  plan.lift->shear_limit_mm = 0.54;
  plan.lift->stick_slip_hz = 25.0;
  plan.lift->stick_slip_mm = 0.1;
  plan.lift->ring_hz = 100.0;
  plan.lift->ring_decay_s = 0.006;
  plan.end_s = 1.4;
  return plan;
}

/// So small that every unlabelled motion is listed to its end.
inline constexpr double any_motion_px = 1e-6;

inline SkinMotion moved(const RunPlan& plan, const SkinView& seen = view, double least_px = any_motion_px) {
  Random random(1);
  return move_skin(plan, seen, 200us, random, least_px);
}

inline std::vector<MarkerMotion> motions_named(const SkinMotion& motion, const std::string& what) {
  std::vector<MarkerMotion> found;
  for (const MarkerMotion& one : motion.motions) {
    if (one.what == what) found.push_back(one);
  }
  return found;
}

inline const SkinPose& pose_at(const SkinMotion& motion, double t_s) {
  return motion.poses[static_cast<std::size_t>(std::lround(t_s / dt_s))];
}

inline double distance_px(const SkinPose& a, const SkinPose& b, const SkinView& seen = view) {
  double distance = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    const double size = std::abs(a[m].scale - b[m].scale) * marker_width_mm * seen.px_per_mm;
    distance = std::max({distance, std::hypot(a[m].x - b[m].x, a[m].y - b[m].y), size});
  }
  return distance;
}

/// What holds for every run, looked at from its poses alone.
inline void expect_true_to_poses(const SkinMotion& motion, const SkinView& seen = view) {
  const auto readout = [](microseconds t) { return static_cast<std::size_t>(t / 200us); };
  std::vector<bool> covered(motion.poses.size() + 2, false);
  microseconds start_before{};
  const MarkerMotion* label_before = nullptr;
  for (const MarkerMotion& one : motion.motions) {
    SCOPED_TRACE(one.what + " at " + std::to_string(one.start.count()));
    EXPECT_GE(one.start, start_before) << "by start";
    EXPECT_GE(one.start, 0us);
    EXPECT_LT(one.start, one.end);
    start_before = one.start;
    EXPECT_EQ(one.labelled, one.what == "press" || one.what == "slip");
    EXPECT_NE(one.touch, Touch::none);
    EXPECT_TRUE(!one.gross || (one.what == "slip" && *one.gross > one.start && *one.gross < one.end));
    if (one.labelled) {
      if (label_before != nullptr) {
        EXPECT_LE(label_before->end, one.start) << "labels never overlap";
      }
      label_before = &one;
    } else {
      for (const MarkerMotion& label : motion.motions)
        EXPECT_TRUE(!label.labelled || label.end <= one.start || label.start >= one.end) << "a label's time is its own";
    }
    // The read-out at or before the start shows the markers before, that at or after the end after.
    const std::size_t first = readout(one.start), last = std::min(readout(one.end) + 1, motion.poses.size() - 1);
    double most_px = 0;
    for (std::size_t k = first; k <= last; ++k)
      most_px = std::max(most_px, distance_px(motion.poses[k], motion.poses[first], seen));
    EXPECT_GT(most_px, any_motion_px) << "only motion is listed";
    for (std::size_t k = first; k <= last; ++k) covered[k + 1] = true;  // covered[k]: between the read-outs k - 1 and k
  }
  for (std::size_t k = 1; k < motion.poses.size();) {
    const std::size_t first = k - 1;
    double most_px = 0;
    for (; k < motion.poses.size() && !covered[k]; ++k)
      most_px = std::max(most_px, distance_px(motion.poses[k], motion.poses[first], seen));
    EXPECT_LT(most_px, 0.05) << "motion that is not listed, from read-out " << first << " to " << k;
    ++k;
  }
}

}  // namespace tactile::simulation
