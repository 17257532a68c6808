#pragma once

#include <optional>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/alignment/motion_phases.hpp"

namespace tactile::alignment {

/// Events in whole milliseconds from the rate's start on, and how many there are when the skin rests.
struct Milliseconds {
  std::vector<double> counts;
  double quiet = 0;       ///< mean
  double dispersion = 1;  ///< variance per mean
};

/// @param rate  its bins are at most a millisecond long; each counts where it begins
Milliseconds milliseconds_of(const EventRate& rate, const QuietRate& quiet);

/// A motion of the arm, placed on the events.
struct PlacedMotion {
  double shift_s = 0;   ///< camera's seconds - robot's
  double sigma_s = 0;   ///< standard deviation
  double common_s = 0;  ///< standard deviation of an error that all runs of its kind share
  double likeness = 0;  ///< share of the rate's variation that the speed explains, 0 to 1
};

// Below, the motion has a profile. `start_s` is its start in seconds of the robot's clock, and `shift_s` the expected shift of
// the camera's seconds, both from any zero; the camera's zero is where the first millisecond begins.

/// The first shear of a lift whose start is expected to a tenth of a second. While the tips follow the arm each millimetre gives
/// as many events as the next,
///
///   rate - quiet = gain * speed(t - shift)
///
/// from where the slack is used up to where the first tip lets go. The arm started where that curve is zero. A shear that is too
/// short for a curve places the start between its onset and `most_slack_m` of travel before it.
/// @return  nothing if no activity begins there
std::optional<PlacedMotion> place_shear(const Milliseconds& ms, const MotionPhase& lift, double start_s, double shift_s,
                                        double most_slack_m);

/// The tips' ringing after a lift's stop, which is expected to a small part of its period: they ring with the arm, so that the
/// rate follows the size of the arm's ringing speed.
/// @return  nothing where it does not stand out clearly
std::optional<PlacedMotion> place_ring_down(const Milliseconds& ms, const MotionPhase& lift, double start_s, double shift_s);

/// A tap whose lowest point is expected to a tenth of a second. While the skin is touched the rate follows the speed: contact and
/// release are symmetric about the lowest point, where the rate is zero.
/// @return  nothing where the speed explains less than a third of the activity
std::optional<PlacedMotion> place_tap(const Milliseconds& ms, const MotionPhase& tap, double start_s, double shift_s);

}  // namespace tactile::alignment
