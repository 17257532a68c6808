#pragma once

#include <span>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/results/detection.hpp"

namespace tactile::evaluation {

struct DelayOptions {
  microseconds window{500'000};     ///< how long after its onset an interval can be detected, > 0
  microseconds head_start{10'000};  ///< an episode that begins at most this long before the onset is its detection, >= 0
};

/// The detection delay of each interval:
///
///   delay = (k - k0 + 1) * tick
///
/// k0 is the first tick after the onset (t_c > start), k the first tick from k0 on whose verdict is right. Missed: no right
/// verdict with t_c <= min(end, start + window). If the verdicts at k0 - 1 and k0 are both the class already, then the delay is
/// one tick where that episode's first tick lies at most `head_start` before k0; else the interval is early.
///
/// @param ticks      the run's full ticks
/// @param verdicts   one for each tick
/// @param intervals  presses and slips
/// @throws Error  if there is not one verdict for each tick
std::vector<results::Detection> detections_of(const TickRange& ticks, std::span<const Touch> verdicts,
                                              std::span<const TouchInterval> intervals, const DelayOptions& options = {});

}  // namespace tactile::evaluation
