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
};

/// Counts the episodes whose first tick is in no interval. One that ran into an onset at most the head start before it is that
/// onset's detection and counts nowhere; one that made an interval early is a false alarm wherever it began. Those that begin
/// within the guard after an interval (end < t_c <= end + guard), else in a release or within the guard after it, else in an
/// unlabelled true interval are counted under these names.
///
/// @param verdicts    one for each tick
/// @param detections  of the same verdicts, by `detections_of`
/// @throws Error  if there is not one verdict for each tick
results::FalseAlarms false_alarms_of(const TickRange& ticks, std::span<const Touch> verdicts, const MotionZones& zones,
                                     std::span<const results::Detection> detections);

/// The false alarms of one run.
struct RunFalseAlarms : results::JudgedRun {
  results::FalseAlarms counts{};
};

/// Widens the interval of false alarms per minute to where it ends no lower than that of the alarms counted, over the none time
/// they were counted in:
///
///   high = max(high, poisson_upper_bound(alarms) / none time)
///
/// Runs drawn from runs without an alarm have none either, however short they are: for 20 s without an alarm, the draws give at
/// most 0 per minute, the count gives up to 11.
///
/// @param per_min  left as it is where it has no interval
/// @param counted  of all that was drawn from
/// @param seeds    > 0; networks that `counted` holds the same runs of: the time is that of one, and so are the alarms, rounded
/// up
void widen_by_few_alarms(results::Figure& per_min, const results::FalseAlarms& counted, double confidence = 0.95,
                         unsigned seeds = 1);

results::FalseAlarmTable false_alarm_table(std::span<const RunFalseAlarms> runs, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
