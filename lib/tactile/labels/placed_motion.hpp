#pragma once

#include <optional>
#include <vector>

#include "tactile/labels/activity.hpp"
#include "tactile/labels/event_rate.hpp"
#include "tactile/robot/arm_motion.hpp"

namespace tactile {

/// Events in whole milliseconds from the rate's begin on, and how many there are when the skin rests.
struct Milliseconds {
  std::vector<double> counts;
  double quiet = 0;       ///< mean
  double dispersion = 1;  ///< variance per mean
};

/// @param rate  its bins are a millisecond long at most; each counts where it begins
Milliseconds milliseconds_of(const EventRate& rate, const QuietRate& quiet);

/// A motion of the arm placed on the events.
struct PlacedMotion {
  double shift_s = 0;   ///< camera's seconds - robot's
  double sigma_s = 0;   ///< standard deviation
  double common_s = 0;  ///< standard deviation of what every run of its kind is off by likewise
  double likeness = 0;  ///< share of what the rate does that the speed explains, 0 to 1
};

// Below, `begin_s` is the motion's `begin` in seconds of the robot's clock and `shift_s` by how much the camera's seconds are
// expected to be ahead, both from whatever zero; the camera's zero is the first millisecond's begin.

/// The first shear of a lift whose start is expected to a tenth of a second. While the tips follow the arm each millimetre gives
/// as many events as the next,
///
///   rate - quiet = gain * speed(t - shift)
///
/// from when the slack is used up to when the first tip lets go. Where that leads down to zero the arm started. A shear that is
/// too short to lead anywhere puts the start between its onset and `most_slack_m` of travel before.
/// @return  nothing if no activity begins there
std::optional<PlacedMotion> place_shear(const Milliseconds& ms, const CommandedMotion& lift, double begin_s, double shift_s,
                                        double most_slack_m);

/// The tips' ringing after a lift's stop, which is expected to a small part of its period: they ring with the arm, so that the
/// rate follows the size of the arm's ringing speed.
/// @return  nothing where it does not stand out beyond doubt
std::optional<PlacedMotion> place_ring_down(const Milliseconds& ms, const CommandedMotion& lift, double begin_s, double shift_s);

/// A tap whose lowest point is expected to a tenth of a second. While the skin is touched the rate follows the speed: contact and
/// release lie alike on either side of the lowest point, at which it is nothing.
/// @return  nothing where less than a third of the activity is explained so
std::optional<PlacedMotion> place_tap(const Milliseconds& ms, const CommandedMotion& tap, double begin_s, double shift_s);

}  // namespace tactile
