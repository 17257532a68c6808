#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tactile/alignment/event_rate.hpp"

namespace tactile::alignment {

/// The event rate of the skin when nothing touches it.
struct QuietRate {
  double mean = 0;        ///< events per bin
  double dispersion = 1;  ///< variance per mean, >= 1: the noise of a sensor is clumped, a Poisson process has 1
};

/// From the median of sums over 5 ms and their median absolute deviation: bursts in less than half of the time do not affect it.
QuietRate quiet_rate(const EventRate& rate);

/// A stretch of bins, [begin, end), with a rate above the quiet one.
struct Burst {
  std::size_t begin = 0;
  std::size_t end = 0;
  double events = 0;  ///< above the quiet rate
  bool slow = false;  ///< stands out in a few places only, not in the rate of the whole image
};

struct ActivityOptions {
  microseconds smoothing{5'000};  ///< sums over this time are compared with the quiet rate
  double enter = 6.0;             ///< [standard deviations] a burst has a sum so far above the quiet rate
  double leave = 3.0;             ///< [standard deviations] it reaches from the first to the last sum so far above it
  microseconds merge{140'000};    ///< bursts that are closer are one: an object that slips sticks in between
  microseconds shortest{15'000};  ///< shorter ones are noise
};

/// The stretches of activity, in order of time.
std::vector<Burst> bursts_in(const EventRate& rate, const QuietRate& quiet, const ActivityOptions& options = {});

/// Events in the bins [begin, end) above what the quiet rate gives.
double events_above(const EventRate& rate, const QuietRate& quiet, std::size_t begin, std::size_t end);

/// Whether a burst is too brief and too small for a touch: less than 40 ms, with less than a tenth of the largest burst's events.
/// A stage takes 0.1 s to press, and an arm longer to lift; tips that spring back take less.
bool is_after_effect(const Burst& burst, const EventRate& rate, std::span<const Burst> bursts);
/// The bursts that are no after-effect of the others, in their order.
std::vector<Burst> without_after_effects(std::span<const Burst> bursts, const EventRate& rate);

}  // namespace tactile::alignment
