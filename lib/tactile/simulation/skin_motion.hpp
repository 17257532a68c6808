#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

inline constexpr unsigned all_markers = (1U << marker_count) - 1U;

/// A motion of markers. Times count from the camera's first read-out.
struct MarkerMotion {
  Touch touch = Touch::press;  ///< its class; the most similar class if it is unlabelled
  std::string what;  ///< "press", "slip"; unlabelled: "release", "relaxation", "recovery", "micro-slip", "partial slip",
                     ///< "turn", "firm shear", "re-contact", "vibration", "tap"
  bool labelled = true;
  microseconds start{};
  microseconds end{};                 ///< by the rules of labels
  std::optional<microseconds> gross;  ///< slip only: object and tip first move against each other
  unsigned markers = all_markers;     ///< bit i: marker i takes part
};

/// The motion of the skin in a run, with its intervals by the rules of labels.
struct SkinMotion {
  std::vector<SkinPose> poses;  ///< one per step, from the camera's first read-out
  microseconds step{200};
  std::vector<MarkerMotion> motions;  ///< by start; only unlabelled ones may overlap each other
  std::optional<microseconds> lift_start;
};

/// Moves the markers through a run, step by step.
///
/// Press: marker m is pushed in by q(t) = max(0, depth(t) - gap). It starts with the object's speed at that time, and moves
/// sideways in proportion. Lift: after the slack, each touched tip is dragged with the object at the arm's speed until the shear
/// reaches its limit. Then it springs back by the stick-slip amplitude, rings, and slides. The object jerks at the stick-slip
/// rate with 15 % jitter. Each jerk makes a share `unison` of the tips stick and be dragged to the limit again, each with its own
/// lag. All of this ends with the arm's motion. Markers that are pressed less than the mean follow it by a share, because the
/// skin is one piece. Creeping, micro-slips, re-contacts, taps and the arm's ringing are added. A micro-slip is opposite to the
/// tip's bending. When the object releases a tip, the tip straightens in proportion.
///
/// In a firm lift the object comes along: the shear of each tip approaches an end, and nothing slips. The object may turn, and
/// the touched tips move with it. A partial slip moves some tips back slowly. Released tips keep a share of their displacement
/// for a while.
///
/// After contact, a press ends at the start of the first 20 ms with tip speed below 1 % of its peak. After its gross part, a slip
/// ends at the start of the first 150 ms with the speed of the object against the tip below 1 % of its peak. Later motion is
/// unlabelled. An unlabelled motion lasts until a marker has last moved by another `least_px`; it is omitted if none does.
/// @param step      > 0
/// @param least_px  what causes events: the `crossing_px` of the camera
SkinMotion move_skin(const RunPlan& plan, const SkinView& view, microseconds step, Random& random, double least_px = 0.34);

}  // namespace tactile::simulation
