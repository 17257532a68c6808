#pragma once

#include <span>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/delay_table.hpp"
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

/// The delay of the same detection from another onset, which may be after the detection: (k - k0 + 1) * tick with k0
/// the first tick after `onset`, zero or negative where the touch was predicted before it. Missed and early ones stay so; their
/// limit is counted from `onset`, too.
results::Detection counted_from(const results::Detection& detection, CameraTime onset, const TickRange& ticks);

/// The delays [ms] that one class can have: from 0, unless they are counted from a later onset, to the longest time after an
/// onset in which an interval could be detected; in steps of the shortest one of all runs, which is a tick or more.
Range range_of_delays(std::span<const results::RunDetections> runs, Touch touch);

/// The curve of detections over all runs, as `delay_table(...).curve`.
std::vector<results::DetectedWithin> detected_within(std::span<const results::RunDetections> runs, Touch touch,
                                                     const results::BootstrapOptions& options = {});

/// Over all runs only, as `delay_table(...).all`.
results::DelaySummary delay_summary(std::span<const results::RunDetections> runs, Touch touch,
                                    const results::BootstrapOptions& options = {});
results::DelayTable delay_table(std::span<const results::RunDetections> runs, Touch touch,
                                const results::BootstrapOptions& options = {});

/// The mean over these very objects of each one's mean delay, with missed and early intervals left out as in the table.
results::Figure mean_delay_of_these_objects(std::span<const results::RunDetections> runs, Touch touch,
                                            const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
