#include "tactile/labels/truth_comparison.hpp"

#include <algorithm>

namespace tactile {
namespace {

microseconds overlap_of(const TouchInterval& a, const TouchInterval& b) {
  return between(std::max(a.start, b.start), std::min(a.end, b.end));
}

}  // namespace

TruthComparison compare_with_truth(const Labels& labels, const Truth& truth) {
  TruthComparison comparison;
  std::vector<bool> paired(labels.intervals.size());
  for (const TrueInterval& true_interval : truth.intervals) {
    if (!true_interval.labelled) continue;
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
      const TouchInterval interval = labels.intervals[i].interval();
      if (interval.touch != true_interval.interval.touch || overlap_of(interval, true_interval.interval) <= 0us) continue;
      if (!best ||
          overlap_of(interval, true_interval.interval) > overlap_of(labels.intervals[*best].interval(), true_interval.interval))
        best = i;
    }
    IntervalComparison compared{
        .touch = true_interval.interval.touch, .start_error = {}, .end_error = {}, .first_event_error = {}, .covered = false};
    if (best) {
      paired[*best] = true;
      const LabelledInterval& found = labels.intervals[*best];
      const CameraTime onset = true_interval.interval.start;
      compared.start_error = between(onset, found.start.at);
      compared.end_error = between(true_interval.interval.end, found.end.at);
      compared.covered = found.start.low <= onset && onset <= found.start.high;
      if (true_interval.first_event) compared.first_event_error = between(*true_interval.first_event, found.start.at);
    }
    comparison.intervals.push_back(compared);
  }
  comparison.spurious = static_cast<std::size_t>(std::count(paired.begin(), paired.end(), false));
  if (!labels.robot_clocks.empty() && truth.robot_clock && truth.lift_start) {
    const std::int64_t lift_in_robot = truth.robot_clock->clock_us_from(*truth.lift_start);
    const ClockRelation& found = labels.robot_clock_at(*truth.lift_start)->relation;
    comparison.robot_clock_error = between(*truth.lift_start, found.camera_from(lift_in_robot));
  }
  return comparison;
}

}  // namespace tactile
