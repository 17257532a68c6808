#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

/// Episodes of one run that began where nothing was, and how long nothing was.
struct FalseAlarms {
  std::uint64_t alarms = 0;           ///< false alarms proper
  std::uint64_t after_intervals = 0;  ///< begun within the guard after an interval
  std::uint64_t unlabelled = 0;       ///< begun in real motion that nobody labels
  microseconds none_time{0};          ///< ticks in no interval, not within the guard after one, in no unlabelled interval
  microseconds after_intervals_time{0};
  microseconds unlabelled_time{0};

  FalseAlarms& operator+=(const FalseAlarms& other);

  std::optional<double> per_min() const;  ///< of none time; nothing where there was none
};

/// Counts the episodes whose first tick is in no interval. One that ran into an onset at most the head start before it is that
/// onset's detection and counts nowhere; one that made an interval early is a false alarm wherever it began. Those that begin
/// within the guard after an interval (end < t_c <= end + guard) or else in an unlabelled true interval are counted under these
/// names.
///
/// @param verdicts    one for each tick
/// @param intervals   every labelled interval, those too whose labels are in doubt
/// @param unlabelled  true intervals that nobody labels; empty for a real run
/// @param detections  of the same verdicts, by `detections_of`
/// @throws Error  if there is not one verdict for each tick
FalseAlarms false_alarms_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> intervals,
                            std::span<const TouchInterval> unlabelled, std::span<const Detection> detections, microseconds guard);

/// The false alarms of one run.
struct RunFalseAlarms {
  std::string object;
  FalseAlarms counts;
};

/// Widens the interval of false alarms per minute to where it ends no lower than that of the alarms counted, over the none time
/// they were counted in:
///
///   high = max(high, poisson_upper_bound(alarms) / none time)
///
/// Runs drawn of runs without an alarm hold none either, however short they are: of 20 s without one, the draws say that there
/// are 0 a minute at most, the count that there may be 11.
///
/// @param per_min  left as it is where it has no interval
/// @param counted  of all that was drawn from
/// @param seeds    > 0; networks that `counted` holds the same runs of: the time is that of one, and so are the alarms, rounded
/// up
void widen_by_few_alarms(Figure& per_min, const FalseAlarms& counted, double confidence = 0.95, unsigned seeds = 1);

/// Per minute of none time, over all runs and of each object; intervals widened by few alarms.
struct FalseAlarmTable {
  Figure per_min;                         ///< all alarms / all none time; objects drawn first, then runs
  std::map<std::string, Figure> objects;  ///< runs drawn
  FalseAlarms total;
};

/// {"count", "none_min", "per_min", "objects", "after_intervals": {"count", "min"}, "unlabelled": {"count", "min"}}
void to_json(nlohmann::json& json, const FalseAlarmTable& table);

FalseAlarmTable false_alarm_table(std::span<const RunFalseAlarms> runs, const BootstrapOptions& options = {});

}  // namespace tactile
