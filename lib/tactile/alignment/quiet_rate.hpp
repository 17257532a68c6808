#pragma once

#include <vector>

#include "tactile/alignment/camera_span.hpp"
#include "tactile/alignment/event_rate.hpp"

namespace tactile::alignment {

/// The event rate of the skin when nothing touches it.
struct QuietRate {
  double mean = 0;        ///< events per bin
  double dispersion = 1;  ///< variance per mean, >= 1: the noise of a sensor is clumped, a Poisson process has 1
};

/// From the median of sums over 5 ms and their median absolute deviation: touches in less than half of the time do not affect it.
QuietRate quiet_rate(const EventRate& rate);

/// Stretches of at least `shortest` without an event that are too long for chance, by time: nothing was recorded.
std::vector<CameraSpan> gaps_in(const EventRate& rate, const QuietRate& quiet, microseconds shortest);

}  // namespace tactile::alignment
