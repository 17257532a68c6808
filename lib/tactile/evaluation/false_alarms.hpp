#pragma once

#include <span>
#include <string>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/results/false_alarm_table.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::evaluation {

/// The stretches of a run that are not `none`.
struct MotionZones {
  std::span<const TouchInterval> intervals;   ///< every labelled one, including those whose labels are in doubt
  std::span<const TouchInterval> releases;    ///< that `label` found
  std::span<const TouchInterval> unlabelled;  ///< true motion without labels; empty for a real run
  microseconds guard{0};                      ///< after an interval or a release, >= 0
  bool knows_motion = true;                   ///< `unlabelled` has all of it; else nothing is counted as outside of motion
};

/// Counts the episodes whose first tick is in no interval. An episode that begins at most the head start before an onset, and
/// lasts into it, is that onset's detection and is not counted. An episode that made an interval early is a false alarm
/// wherever it began. Episodes that begin within the guard after an interval (end < t_c <= end + guard), in a release or within
/// the guard after it, or in an unlabelled true interval are counted under the first of these names that fits.
///
/// Three forms count an episode again for each further 500 ms. A detector that stays on one class therefore has many in any
/// recording:
///
///   outside_labels   ticks in no labelled interval. An episode counts once where its first tick is one of them, as above, and
///                    then once for each whole 500 ms more of them that it holds. One that began in an interval, or that detects
///                    an onset, counts only for each 500 ms after.
///   outside_motion   the same for the ticks that are in no unlabelled true interval either
///   wrong_class      an episode of another class than an interval counts where it begins in the interval, or holds more than the
///                    guard of it, and again for each 500 ms more in it. Only intervals of `detections` are taken.
///
/// @param verdicts    one for each tick
/// @param detections  of the same verdicts, by `detections_of`, of the intervals whose labels are not in doubt
/// @throws Error  if there is not one verdict for each tick
results::FalseAlarms false_alarms_of(const TickRange& ticks, std::span<const Touch> verdicts, const MotionZones& zones,
                                     std::span<const results::Detection> detections);

/// The false alarms of one run.
struct RunFalseAlarms : results::JudgedRun {
  results::FalseAlarms counts{};
};

/// Widens the interval of false alarms per minute. It then ends no lower than the interval of their count over the none time:
///
///   high = max(high, poisson_upper_bound(alarms) / none time)
///
/// Draws of runs without an alarm have no alarm either, however short the runs are. For 20 s without an alarm, the draws give
/// at most 0 per minute, the count gives up to 11.
///
/// @param per_min  left as it is where it has no interval
/// @param counted  of all that was drawn from
/// @param seeds    > 0; networks that `counted` holds the same runs of: the time is that of one, and so are the alarms, rounded
/// up
void widen_by_few_alarms(results::Figure& per_min, const results::FalseAlarms& counted, double confidence = 0.95,
                         unsigned seeds = 1);

/// The same for alarms of any kind, counted in `time`.
void widen_by_few_alarms(results::Figure& per_min, std::uint64_t alarms, microseconds time, double confidence,
                         unsigned seeds = 1);

/// Of alarms per minute: at most one each tick. @param time  of all these results together
Range range_of_rates(std::size_t results, microseconds time, microseconds tick);

results::FalseAlarmTable false_alarm_table(std::span<const RunFalseAlarms> runs, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
