#pragma once

#include <cstdint>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

/// How the skin moves in a run, and when by the rules that labels follow. Times count from the camera's first read-out.
struct SkinMotion {
  std::vector<SkinPose> poses;  ///< one per read-out, from the first
  microseconds press_start{};   ///< first motion of a marker by contact
  microseconds press_end{};     ///< first instant of the first 20 ms with marker speed below 1 % of its peak
  microseconds lift_start{};    ///< the arm begins to move
  microseconds slip_start{};    ///< first motion of a tip driven by the lift
  microseconds gross{};         ///< object and tip first move against each other
  microseconds slip_end{};      ///< first instant of the first 150 ms with relative speed below 1 % of its peak
};

/// Moves the markers through a run, read-out by read-out.
///
/// Press: marker m is pushed in by q(t) = max(0, depth(t) - gap), so it starts at the speed that the object has by then, and goes
/// aside in proportion. Lift: once the arm has travelled the slack, each touched tip is dragged along with the object at the
/// arm's speed until the shear reaches its limit; it then springs back by the stick-slip amplitude, ringing, and slides. Jerks of
/// the object come at the stick-slip rate with 15 % jitter; each makes a share of the tips, `unison`, stick and be dragged to the
/// limit again, every tip with a lag of its own. All of it ends with the arm's motion. Markers that are touched less than the
/// mean follow it by 6 %: the skin is one piece.
SkinMotion move_skin(const RunPlan& plan, microseconds readout, Random& random);

}  // namespace tactile
