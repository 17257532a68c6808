#pragma once

#include "tactile/alignment/anchor_search.hpp"

namespace tactile::alignment {

/// Looks for moments that the robot's log and the recording both show. Nothing need be known of the two clocks. The witnesses:
///
/// - The IMU (`imu_anchors.hpp`).
/// - Without an IMU, the activity of the skin against the motion of the arm (`event_anchors.hpp`).
/// - Sync taps, each placed by its lowest point: speed and rate are zero between contact and release.
/// - The first shear of a lift. While the tips follow the arm, the rate grows with the arm's speed. It shows when the speed was
///   zero, not when the first tip moved: the slack between the two does not enter. If the shear is too short for this, the lift
///   began up to 0.5 mm of slack before the onset, and the anchor has this width.
/// - The ring-down after a lift's stop, where the rate clearly follows the ringing of the log.
/// - The stage's output (`stage_anchors.hpp`).
/// - Host times (`host_anchors.hpp`).
///
/// An ambiguous match is refused, with a sentence in `doubts`. An arm that rests leaves only the stage and the host.
/// Source: Faris et al., arXiv:2403.10120, section IV, for events against the lift.
FoundAnchors clock_anchors(const AnchorInputs& inputs, const AnchorOptions& options = {});

}  // namespace tactile::alignment
