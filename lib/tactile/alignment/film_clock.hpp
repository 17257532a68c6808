#pragma once

#include <optional>
#include <span>
#include <string>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/alignment/motion_energy.hpp"
#include "tactile/core/doubt.hpp"

namespace tactile::alignment {

/// What a film of the run must have seen move, and how fast.
struct SeenMotion {
  CameraTime begin{};
  microseconds step{4'000};      ///< > 0
  std::span<const float> speed;  ///< at begin + i * step, straight lines in between; >= 0 in any unit, NaN where it is not known
  double sigma_us = 0;           ///< standard deviation of its place in camera time, >= 0
};

/// The film's clock, or why it could not be found.
struct FilmClock {
  std::optional<FittedClock> clock;
  std::string refused;       ///< a sentence, empty if there is a clock
  Doubt contradiction = {};  ///< why the film may be of another recording than the robot log; empty if nothing shows it
  std::string remark = {};   ///< a sentence on the film's times, empty if there is none
};

/// Relates a film's clock to the camera's by what moves in both. Energy and speed of each step from frame to frame have a
/// correlation r, if a time x of the film is x + o + g (x + o - m) in camera time, m being the middle of the motions:
///
///   ln p(film | o, g, w) = -n / 2 * ln(1 - r^2)
///
/// w is by how much longer each motion is in the film than by the arm: a film does not show slow motion, but shows the ringing
/// after a motion. n is the number of independent steps. One step in 0.3 s is independent. How exact o and g are depends on the
/// steps with motion alone: of these, one in 60 ms. Priors: o is even over all offsets at which both overlap, w has a standard
/// deviation of 20 ms, g one of 0.5 % (1.5 % if the times count frames, since films lose about 1 % of them). One motion does not
/// separate g from w.
///
/// The clock's offset, its interval and its drift are those of the posterior; the interval includes that of the arm's motion.
///
/// Refused where chance explains the film as well (probability above 0.05), or another offset does; where film and log are too
/// long to look at all offsets and drifts, which takes 10 min and more; and where a w of up to 0.4 s, or a g of up to 30 % (less
/// if the motions span more than 13 s), fits better than the usual ones by 12 nats, and these leave a tenth of the energies'
/// variance or more: for its w as a contradiction, for its g as another rate.
/// @param energy  of the run's film
/// @param seen    of the same run. Other motion in the film makes the clock less certain. A stronger one of the same length may
///                be taken for the arm's
FilmClock film_clock(const MotionEnergy& energy, const SeenMotion& seen);

/// Sets how fast a film's clock may drift from the film's middle on, by what is usual, where it was found without the arm.
/// @return  a remark on the film's times, empty if there is none
std::string allow_for_drift(FittedClock& clock, const MotionEnergy& energy);

}  // namespace tactile::alignment
