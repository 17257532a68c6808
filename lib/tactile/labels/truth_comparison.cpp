#include "tactile/labels/truth_comparison.hpp"

#include <algorithm>

namespace tactile::labels {
namespace {

Deviation deviation_of(const alignment::UncertainTime& labelled, CameraTime truly) {
  return {.error = between(truly, labelled.at),
          .covered = labelled.low <= truly && truly <= labelled.high,
          .width = between(labelled.low, labelled.high)};
}

/// At a moment that is `truly` there by the camera's clock.
Deviation deviation_of(const alignment::FittedClock& found, const ClockRelation& clock, CameraTime truly) {
  const microseconds error = between(truly, found.relation.camera_from(clock.clock_us_from(truly)));
  const std::int64_t true_offset_us = saturating_subtract(found.relation.offset_us, error.count());
  const std::int64_t by_drift_us = (found.uncertainty_at(truly) - found.uncertainty()).count();
  const std::int64_t low_us = saturating_subtract(found.offset_low_us, by_drift_us);
  const std::int64_t high_us = saturating_add(found.offset_high_us, by_drift_us);
  return {.error = error,
          .covered = low_us <= true_offset_us && true_offset_us <= high_us,
          .width = microseconds{saturating_subtract(high_us, low_us)}};
}

/// The label of its class that overlaps the true interval most.
std::optional<std::size_t> label_for(const TouchInterval& truly, const std::vector<LabelledInterval>& labels) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const TouchInterval interval = labels[i].interval();
    if (interval.touch != truly.touch || overlap(interval, truly) <= 0us) continue;
    if (!best || overlap(interval, truly) > overlap(labels[*best].interval(), truly)) best = i;
  }
  return best;
}

}  // namespace

TruthComparison compare_with_truth(const Labels& labels, const Truth& truth) {
  TruthComparison comparison;
  comparison.clocks_flagged = labels.run_is_flagged();
  comparison.flagged =
      std::any_of(labels.flags.begin(), labels.flags.end(), [](const LabelFlag& flag) { return !flag.confirmed; });
  const auto flagged = [&](std::size_t index) { return labels.run_is_flagged() || labels.interval_is_flagged(index); };
  std::vector<bool> paired(labels.intervals.size());
  std::optional<CameraTime> moment = truth.lift_start;
  for (const TrueInterval& true_interval : truth.intervals) {
    if (!true_interval.labelled) continue;
    const TouchInterval& truly = true_interval.interval;
    if (!moment) moment = truly.start;
    IntervalComparison compared;
    compared.touch = truly.touch;
    compared.true_start = truly.start;
    compared.flagged = labels.run_is_flagged();
    if (const std::optional<std::size_t> best = label_for(truly, labels.intervals)) {
      paired[*best] = true;
      const LabelledInterval& found = labels.intervals[*best];
      compared.start = deviation_of(found.start, truly.start);
      compared.end = deviation_of(found.end, truly.end);
      if (true_interval.first_event) compared.first_event = deviation_of(found.start, *true_interval.first_event);
      compared.flagged = flagged(*best);
    }
    comparison.intervals.push_back(compared);
  }
  for (std::size_t i = 0; i < paired.size(); ++i) {
    if (!paired[i]) comparison.spurious.push_back({labels.intervals[i].interval(), flagged(i)});
  }
  if (!moment) return comparison;
  comparison.robot_clock_sought = truth.robot_clock.has_value();
  comparison.video_clock_sought = truth.video_clock.has_value();
  if (!labels.robot_clocks.empty() && truth.robot_clock)
    comparison.robot_clock = deviation_of(*labels.robot_clock_at(*moment), *truth.robot_clock, *moment);
  if (labels.video_clock && truth.video_clock)
    comparison.video_clock = deviation_of(*labels.video_clock, *truth.video_clock, *moment);
  return comparison;
}

}  // namespace tactile::labels
