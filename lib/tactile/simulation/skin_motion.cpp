#include "tactile/simulation/skin_motion.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>

#include "tactile/core/infinite.hpp"
#include "tactile/simulation/moving_tips.hpp"

namespace tactile::simulation {
namespace {

constexpr double press_still_s = 0.020;

microseconds whole_us(double seconds) { return microseconds{std::llround(1e6 * seconds)}; }

/// The start of the first 20 ms in which the tip speed of a press is below 1 % of its peak. Speeds are exact; only the search
/// samples.
double press_end_s(const PressPlan& press, double until_s) {
  std::array<double, marker_count> path_share{};  // a tip's displacement, inward and sideways, per displacement of the object
  double peak = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    const MarkerContact& marker = press.markers[m];
    if (marker.gap_mm >= press.depth_mm) continue;
    path_share[m] = std::hypot(1.0, marker.pull_x, marker.pull_y);
    const double part = 1.0 - std::pow(1.0 - marker.gap_mm / press.depth_mm, 1.0 / (press.press_power + 1.0));
    peak = std::max(peak, path_share[m] * press.speed_at(press.contact_s + part * press.press_s));
  }
  const auto moves = [&](double t_s) {
    const double depth_mm = press.depth_at(t_s);
    double share = 0;
    for (std::size_t m = 0; m < marker_count; ++m) {
      if (depth_mm >= press.markers[m].gap_mm) share = std::max(share, path_share[m]);
    }
    return share * press.speed_at(t_s) >= still_share * peak;
  };
  constexpr double step_s = 1e-4;
  double moved_s = press.contact_s;
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter)
  for (double t_s = press.contact_s; t_s < moved_s + press_still_s && t_s < until_s; t_s += step_s) {
    if (moves(t_s)) moved_s = t_s;
  }
  double still_s = moved_s + step_s;
  while (still_s - moved_s > 1e-8) {
    const double middle_s = 0.5 * (moved_s + still_s);
    (moves(middle_s) ? moved_s : still_s) = middle_s;
  }
  return std::min(still_s, until_s);
}

/// Collects motions, and removes the times of the labelled ones from the others.
class MotionList {
 public:
  explicit MotionList(double until_s) : until_s_(until_s) {}

  void add(Touch touch, const char* what, bool labelled, double start_s, double end_s, unsigned markers = all_markers) {
    start_s = std::max(start_s, 0.0);
    end_s = std::min(end_s, until_s_);
    if (whole_us(end_s) > whole_us(start_s)) {
      motions_.push_back({.touch = touch,
                          .what = what,
                          .labelled = labelled,
                          .start = whole_us(start_s),
                          .end = whole_us(end_s),
                          .gross = {},
                          .markers = markers});
    }
  }

  /// @param last_visible  of a start and an end: when the motion between them is last visible; the start if it is not
  template <class LastVisible>
  std::vector<MarkerMotion> finished(const LastVisible& last_visible) {
    std::stable_sort(motions_.begin(), motions_.end(), starts_before);
    std::vector<MarkerMotion> all, others;
    for (const MarkerMotion& motion : motions_) {
      if (motion.labelled) {
        if (!all.empty()) all.back().end = std::min(all.back().end, motion.start);
        all.push_back(motion);
      } else {
        others.push_back(motion);
      }
    }
    std::erase_if(all, [](const MarkerMotion& motion) { return motion.end <= motion.start; });
    const std::vector<MarkerMotion> labelled = all;
    const auto keep = [&](MarkerMotion piece, microseconds end) {
      piece.end = end > piece.start ? last_visible(piece.start, end) : piece.start;
      if (piece.end > piece.start) all.push_back(piece);
    };
    for (MarkerMotion motion : others) {
      for (const MarkerMotion& label : labelled) {
        if (label.start >= motion.end || label.end <= motion.start) continue;
        if (label.start > motion.start) keep(motion, label.start);
        motion.start = label.end;
      }
      keep(motion, motion.end);
    }
    std::stable_sort(all.begin(), all.end(), starts_before);
    return all;
  }

 private:
  static bool starts_before(const MarkerMotion& a, const MarkerMotion& b) { return a.start < b.start; }

  double until_s_;
  std::vector<MarkerMotion> motions_;
};

void add_presses(MotionList& list, const RunPlan& plan) {
  for (const PressPlan& press : plan.presses) {
    const double shut_s = press.release_start_s.value_or(infinite);
    const double end_s = press_end_s(press, std::min(shut_s, plan.end_s));
    list.add(Touch::press, "press", press.contact_s >= 0, press.contact_s, end_s);
    list.add(Touch::press, "relaxation", false, end_s, std::min(press.creeping_end_s(), shut_s));
    if (!press.release_start_s) continue;
    const double free_s = shut_s + press.release_s, kept_mm = plan.hysteresis_share * press.depth_mm;
    list.add(Touch::press, "release", false, shut_s, free_s);
    list.add(Touch::press, "recovery", false, free_s, free_s + ringing_s(kept_mm, plan.hysteresis_s));
  }
}

void add_after_effects(MotionList& list, const RunPlan& plan, std::span<const MicroSlip> slips) {
  for (const MicroSlip& slip : slips)
    list.add(Touch::slip, slip.is_partial() ? "partial slip" : "micro-slip", false, slip.plan->at_s, slip.end_s(),
             slip.plan->markers);
  for (const TurnPlan& turn : plan.turns) list.add(Touch::slip, "turn", false, turn.start_s, turn.end_s());
  for (const RecontactPlan& rocks : plan.recontacts) list.add(Touch::press, "re-contact", false, rocks.start_s, rocks.end_s());
  for (const TapPlan& tap : plan.taps) list.add(Touch::press, "tap", false, tap.contact_s(), tap.free_s());
}

/// The ringing of the arm, and of the tips after a slip: one motion if they overlap.
void add_vibrations(MotionList& list, const RunPlan& plan, double tail_start_s, double tail_end_s) {
  std::vector<std::pair<double, double>> rings;
  for (const auto& [at_s, change] : plan.arm_acceleration_changes())
    rings.emplace_back(at_s, at_s + plan.vibration.lasts_s(change));
  if (tail_end_s > tail_start_s) rings.emplace_back(tail_start_s, tail_end_s);
  std::sort(rings.begin(), rings.end());
  for (std::size_t i = 0; i < rings.size();) {
    const double start_s = rings[i].first;
    double end_s = rings[i].second;
    for (++i; i < rings.size() && rings[i].first <= end_s; ++i) end_s = std::max(end_s, rings[i].second);
    list.add(Touch::slip, "vibration", false, start_s, end_s);
  }
}

/// When a marker has last moved by `least_px` since it had done so before, between two times; the start if none has.
microseconds last_visible(std::span<const SkinPose> poses, const SkinView& view, microseconds step, double least_px,
                          microseconds start, microseconds end) {
  const auto first = static_cast<std::size_t>(start / step);
  const auto last = std::min(static_cast<std::size_t>((end + step - 1us) / step), poses.size() - 1);
  SkinPose seen = poses[first];
  microseconds at = start;
  for (std::size_t k = first + 1; k <= last; ++k) {
    for (std::size_t m = 0; m < marker_count; ++m) {
      const MarkerPose& now = poses[k][m];
      const double size_px = std::abs(now.scale - seen[m].scale) * marker_width_mm * view.px_per_mm;
      if (std::max(std::hypot(now.x - seen[m].x, now.y - seen[m].y), size_px) <= least_px) continue;
      seen[m] = now;
      at = std::min(end, step * static_cast<std::int64_t>(k));
    }
  }
  return at;
}

}  // namespace

SkinMotion move_skin(const RunPlan& plan, const SkinView& view, microseconds step, Random& random, double least_px) {
  assert(step > 0us && "steps follow each other in time");
  const double dt_s = 1e-6 * static_cast<double>(step.count());
  const auto steps = static_cast<std::size_t>(std::floor(plan.end_s / dt_s + 1e-6)) + 1;
  MovingTips tips(plan, view, dt_s, random);
  SkinMotion motion;
  motion.step = step;
  motion.poses.reserve(steps);
  for (std::size_t k = 0; k < steps; ++k) motion.poses.push_back(tips.advance_to(static_cast<double>(k) * dt_s, random));

  MotionList list(static_cast<double>(steps - 1) * dt_s);
  add_presses(list, plan);
  add_after_effects(list, plan, tips.micro_slips());
  const DraggedTips& dragged = tips.dragged();
  double tail_start_s = infinite;
  if (dragged.drags()) {
    tail_start_s = dragged.end_s();
    list.add(Touch::slip, dragged.is_firm() ? "firm shear" : "slip", !dragged.is_firm(), dragged.start_s(), tail_start_s);
  }
  add_vibrations(list, plan, tail_start_s, dragged.ringing_end_s());
  motion.motions = list.finished(
      [&](microseconds start, microseconds end) { return last_visible(motion.poses, view, step, least_px, start, end); });
  for (MarkerMotion& moved : motion.motions) {
    if (moved.what == "slip" && dragged.gross_s() < infinite) moved.gross = whole_us(dragged.gross_s());
  }
  if (plan.lift) motion.lift_start = whole_us(plan.lift->start_s);
  return motion;
}

}  // namespace tactile::simulation
