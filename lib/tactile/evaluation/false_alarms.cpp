#include "tactile/evaluation/false_alarms.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/episodes.hpp"

namespace tactile::evaluation {
namespace {

enum class Zone : std::uint8_t { in_interval, after_interval, release, unlabelled, none };

Zone zone_of(CameraTime tick, const MotionZones& zones) {
  const auto holds = [tick](const TouchInterval& interval) { return interval.contains(tick); };
  const auto just_ended = [tick, &zones](const TouchInterval& interval) {
    return interval.end < tick && tick <= after(interval.end, zones.guard);
  };
  const auto any = [](std::span<const TouchInterval> of, const auto& is_so) { return std::any_of(of.begin(), of.end(), is_so); };
  if (any(zones.intervals, holds)) return Zone::in_interval;
  if (any(zones.intervals, just_ended)) return Zone::after_interval;
  if (any(zones.releases, holds) || any(zones.releases, just_ended)) return Zone::release;
  return any(zones.unlabelled, holds) ? Zone::unlabelled : Zone::none;
}

}  // namespace

results::FalseAlarms false_alarms_of(const TickRange& ticks, std::span<const Touch> verdicts, const MotionZones& zones,
                                     std::span<const results::Detection> detections) {
  if (static_cast<std::int64_t>(verdicts.size()) != ticks.count) {
    throw Error("false alarms: " + std::to_string(verdicts.size()) + " verdicts for " + std::to_string(ticks.count) +
                " ticks; expected one for each");
  }
  const auto zone_at = [&](std::int64_t index) { return zone_of(ticks.at(index), zones); };
  results::FalseAlarms found;
  for (std::int64_t i = 0; i < ticks.count; ++i) {
    const Zone zone = zone_at(i);
    if (zone == Zone::none) found.none_time += ticks.tick;
    if (zone == Zone::after_interval) found.after_intervals_time += ticks.tick;
    if (zone == Zone::release) found.releases_time += ticks.tick;
    if (zone == Zone::unlabelled) found.unlabelled_time += ticks.tick;
  }
  for (const Episode& episode : episodes_in(verdicts)) {
    const auto led_to = [&](results::DetectionOutcome outcome) {
      return std::any_of(detections.begin(), detections.end(), [&](const results::Detection& detection) {
        return detection.leading_episode == episode.first && detection.outcome == outcome;
      });
    };
    const bool spoilt_an_interval = led_to(results::DetectionOutcome::early);
    if (!spoilt_an_interval && led_to(results::DetectionOutcome::detected)) continue;
    switch (zone_at(episode.first)) {
      case Zone::in_interval:
        found.alarms += spoilt_an_interval ? 1 : 0;
        break;
      case Zone::after_interval:
        ++found.after_intervals;
        break;
      case Zone::release:
        ++found.releases;
        break;
      case Zone::unlabelled:
        ++found.unlabelled;
        break;
      case Zone::none:
        ++found.alarms;
        break;
    }
  }
  return found;
}

void widen_by_few_alarms(results::Figure& per_min, const results::FalseAlarms& counted, double confidence, unsigned seeds) {
  if (!per_min.high || counted.none_time <= microseconds{0}) return;
  const auto of_a_seed = static_cast<std::uint64_t>(std::ceil(static_cast<double>(counted.alarms) / seeds));
  per_min.high =
      std::max(*per_min.high, poisson_upper_bound(of_a_seed, confidence) / (results::in_minutes(counted.none_time) / seeds));
}

results::FalseAlarmTable false_alarm_table(std::span<const RunFalseAlarms> runs, const results::BootstrapOptions& options) {
  const auto objects = results_by_object(runs, [](const RunFalseAlarms& run) { return run.counts.none_time > microseconds{0}; });
  const auto sum_of = [runs](const RunsByObject& chosen) {
    results::FalseAlarms sum;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) sum += runs[i].counts;
    }
    return sum;
  };
  const Statistic per_min = [sum_of](const RunsByObject& chosen) { return sum_of(chosen).per_min(); };
  const auto in_steps_of_one_alarm = [](std::size_t units, const results::FalseAlarms& counted) {
    return Range{.lowest = 0, .step = static_cast<double>(units) / results::in_minutes(counted.none_time)};
  };
  results::FalseAlarmTable table;
  for (const RunFalseAlarms& run : runs) table.total += run.counts;
  for (const auto& [name, cells] : objects) {
    results::Figure& of_object = table.objects[name];
    of_object = figure_of_object(cells, per_min, options, in_steps_of_one_alarm(cells.size(), sum_of({indexes_of(cells)})));
    widen_by_few_alarms(of_object, sum_of({indexes_of(cells)}), options.confidence);
  }
  table.per_min =
      figure_over_objects(without_names(objects), per_min, options, in_steps_of_one_alarm(objects.size(), table.total));
  widen_by_few_alarms(table.per_min, table.total, options.confidence);
  return table;
}

}  // namespace tactile::evaluation
