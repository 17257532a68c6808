#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

inline constexpr unsigned all_markers = (1U << marker_count) - 1U;

/// A stretch in which markers move. Times count from the camera's first read-out.
struct MarkerMotion {
  Touch touch = Touch::press;  ///< what it is, or what it is like where nobody labels it
  std::string what;  ///< "press", "slip"; unlabelled: "release", "relaxation", "micro-slip", "re-contact", "vibration", "tap"
  bool labelled = true;
  microseconds start{};
  microseconds end{};                 ///< by the rules that labels follow
  std::optional<microseconds> gross;  ///< slip only: object and tip first move against each other
  unsigned markers = all_markers;     ///< bit i: marker i takes part
};

/// How the skin moves in a run, and when by the rules that labels follow.
struct SkinMotion {
  std::vector<SkinPose> poses;        ///< one per read-out, from the first
  std::vector<MarkerMotion> motions;  ///< by start; labelled ones overlap none, unlabelled ones may overlap each other
  std::optional<microseconds> lift_start;
};

/// Moves the markers through a run, read-out by read-out.
///
/// Press: marker m is pushed in by q(t) = max(0, depth(t) - gap), so it starts at the speed that the object has by then, and goes
/// aside in proportion. Lift: once the arm has travelled the slack, each touched tip is dragged along with the object at the
/// arm's speed until the shear reaches its limit; it then springs back by the stick-slip amplitude, ringing, and slides. Jerks of
/// the object come at the stick-slip rate with 15 % jitter; each makes a share of the tips, `unison`, stick and be dragged to the
/// limit again, every tip with a lag of its own. All of it ends with the arm's motion. Markers that are touched less than the
/// mean follow it by a share: the skin is one piece. Creeping, micro-slips, re-contacts, taps and the arm's ringing come on top;
/// a micro-slip is against the way that the tip is bent. As the object lets go of a tip, the tip stands up again in proportion.
///
/// A press ends, from contact on, at the first instant of the first 20 ms with tip speed below 1 % of its peak; a slip, from its
/// gross part on, at that of the first 150 ms with the speed of object against tip below 1 % of its peak. Motion that goes on
/// after it is unlabelled. No motion is told of that moves no marker by a hundredth of a pixel.
/// @param readout  > 0
SkinMotion move_skin(const RunPlan& plan, const SkinView& view, microseconds readout, Random& random);

}  // namespace tactile
