#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/clock_fit.hpp"
#include "tactile/alignment/motion_energy.hpp"
#include "tactile/core/doubt.hpp"

namespace tactile::alignment {

/// The video's clock, or why it could not be found.
struct VideoClockFit {
  std::optional<FittedClock> clock;
  std::string refused;               ///< a sentence, empty if there is a clock
  Doubt contradiction;               ///< why the film may be of another recording than the robot log; empty if nothing shows it
  double likeness = 0;               ///< at the best offset, -1 to 1
  double ambiguity = 0;              ///< best likeness over the next best; 99 where there is no other
  std::vector<ClockAnchor> anchors;  ///< the middle of each motion, or its start or end
  std::string remark = {};           ///< a sentence on the film's times, empty if there is none
};

/// Fits the line through the anchors, `fit_clock`. One run's film allows no drift: it is 0, unless four motions over 60 s and
/// more allow a line. The interval of the offset holds where the anchors are. From there the clock may drift: the rates of films
/// are off by 0.5 % (standard deviation), and films whose times count frames also lack one frame in a hundred. Counted times may
/// also have a rate that is not the film's, such as index / 25 of a film of 30 frames/s. Refused where the distances of the
/// motions show it beyond three standard deviations; where they cannot, such as with one motion, the remark says so.
VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy);

/// Sets from where on, and how fast, a film's clock that was found by its motions may drift: as `with_clock` has it, from the
/// film's middle. @return  the remark on its times, empty if there is none
std::string allow_for_drift(FittedClock& clock, const MotionEnergy& energy);

}  // namespace tactile::alignment
