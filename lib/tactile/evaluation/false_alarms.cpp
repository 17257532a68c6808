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

/// How often an episode counts: once if it begins `here`, and again for each further `again_after` that it holds.
constexpr microseconds again_after{500'000};

std::uint64_t counts_of(bool begins_here, microseconds held) {
  if (held <= microseconds{0}) return begins_here ? 1 : 0;
  // The tick that ends a whole `again_after` does not begin the next one.
  const microseconds further = begins_here ? held - microseconds{1} : held;
  return (begins_here ? 1 : 0) + static_cast<std::uint64_t>(further / again_after);
}

/// What the ticks of a run are.
class TickZones {
 public:
  TickZones(const TickRange& ticks, const MotionZones& zones) : ticks_(ticks), zones_(zones) {
    for (std::int64_t i = 0; i < ticks.count; ++i) {
      const CameraTime t = ticks.at(i);
      zone_.push_back(zone_of(t, zones));
      const auto holds = [t](const TouchInterval& interval) { return interval.contains(t); };
      in_unlabelled_.push_back(std::any_of(zones.unlabelled.begin(), zones.unlabelled.end(), holds));
    }
  }

  Zone zone(std::int64_t index) const { return zone_[static_cast<std::size_t>(index)]; }
  bool is_outside_labels(std::int64_t index) const { return zone(index) != Zone::in_interval; }
  bool is_outside_motion(std::int64_t index) const {
    return zones_.knows_motion && is_outside_labels(index) && !in_unlabelled_[static_cast<std::size_t>(index)];
  }

  /// The time of an episode's ticks that are `wanted`.
  template <class Wanted>
  microseconds held(const Episode& episode, Wanted wanted) const {
    std::int64_t ticks = 0;
    for (std::int64_t i = episode.first; i <= episode.last; ++i) ticks += wanted(i) ? 1 : 0;
    return ticks_.tick * ticks;
  }

  void add_times(results::FalseAlarms& found, std::span<const Touch> verdicts) const {
    for (std::int64_t i = 0; i < ticks_.count; ++i) {
      if (zone(i) == Zone::none) found.none_time += ticks_.tick;
      if (zone(i) == Zone::after_interval) found.after_intervals_time += ticks_.tick;
      if (zone(i) == Zone::release) found.releases_time += ticks_.tick;
      if (zone(i) == Zone::unlabelled) found.unlabelled_time += ticks_.tick;
      if (is_outside_labels(i)) found.outside_labels_time += ticks_.tick;
      if (is_outside_motion(i)) found.outside_motion_time += ticks_.tick;
      if (verdicts[static_cast<std::size_t>(i)] == Touch::none) continue;
      if (zone(i) == Zone::none) found.none_in_alarm += ticks_.tick;
      if (is_outside_labels(i)) found.outside_labels_in_alarm += ticks_.tick;
      if (is_outside_motion(i)) found.outside_motion_in_alarm += ticks_.tick;
    }
  }

 private:
  TickRange ticks_;
  MotionZones zones_;
  std::vector<Zone> zone_;
  std::vector<bool> in_unlabelled_;
};

/// Counts an episode by where it begins, once.
void count_once(results::FalseAlarms& found, Zone zone, bool spoilt_an_interval) {
  switch (zone) {
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

void add_wrong_class(results::FalseAlarms& found, const TickRange& ticks, std::span<const Episode> episodes,
                     const TouchInterval& interval, microseconds guard) {
  const auto in_it = [&](std::int64_t index) { return interval.contains(ticks.at(index)); };
  for (std::int64_t i = 0; i < ticks.count; ++i) found.labelled_time += in_it(i) ? ticks.tick : microseconds{0};
  for (const Episode& episode : episodes) {
    if (episode.touch == interval.touch || ticks.at(episode.first) > interval.end || ticks.at(episode.last) <= interval.start)
      continue;
    std::int64_t count = 0;
    for (std::int64_t i = episode.first; i <= episode.last; ++i) count += in_it(i) ? 1 : 0;
    const microseconds held = ticks.tick * count;
    found.wrong_class_time += held;
    const bool counts = held > microseconds{0} && (in_it(episode.first) || held > guard);
    found.wrong_class += counts ? counts_of(true, held) : 0;
  }
}

}  // namespace

results::FalseAlarms false_alarms_of(const TickRange& ticks, std::span<const Touch> verdicts, const MotionZones& zones,
                                     std::span<const results::Detection> detections) {
  if (static_cast<std::int64_t>(verdicts.size()) != ticks.count) {
    throw Error("false alarms: " + std::to_string(verdicts.size()) + " verdicts for " + std::to_string(ticks.count) +
                " ticks; expected one for each");
  }
  const TickZones of_ticks(ticks, zones);
  results::FalseAlarms found;
  found.tick = ticks.tick;
  of_ticks.add_times(found, verdicts);
  const std::vector<Episode> episodes = episodes_in(verdicts);
  for (const Episode& episode : episodes) {
    const auto led_to = [&](results::DetectionOutcome outcome) {
      return std::any_of(detections.begin(), detections.end(), [&](const results::Detection& detection) {
        return detection.leading_episode == episode.first && detection.outcome == outcome;
      });
    };
    const bool spoilt_an_interval = led_to(results::DetectionOutcome::early);
    const bool detects = !spoilt_an_interval && led_to(results::DetectionOutcome::detected);
    const auto outside_labels = [&](std::int64_t i) { return of_ticks.is_outside_labels(i); };
    const auto outside_motion = [&](std::int64_t i) { return of_ticks.is_outside_motion(i); };
    found.outside_labels +=
        counts_of(spoilt_an_interval || (!detects && outside_labels(episode.first)), of_ticks.held(episode, outside_labels));
    found.outside_motion += counts_of((spoilt_an_interval && zones.knows_motion) || (!detects && outside_motion(episode.first)),
                                      of_ticks.held(episode, outside_motion));
    if (!detects) count_once(found, of_ticks.zone(episode.first), spoilt_an_interval);
  }
  for (const results::Detection& detection : detections) add_wrong_class(found, ticks, episodes, detection.interval, zones.guard);
  return found;
}

void widen_by_few_alarms(results::Figure& per_min, std::uint64_t alarms, microseconds time, double confidence, unsigned seeds) {
  if (!per_min.high || time <= microseconds{0}) return;
  const auto of_a_seed = static_cast<std::uint64_t>(std::ceil(static_cast<double>(alarms) / seeds));
  per_min.high = std::max(*per_min.high, poisson_upper_bound(of_a_seed, confidence) / (results::in_minutes(time) / seeds));
}

void widen_by_few_alarms(results::Figure& per_min, const results::FalseAlarms& counted, double confidence, unsigned seeds) {
  widen_by_few_alarms(per_min, counted.alarms, counted.none_time, confidence, seeds);
}

Range range_of_rates(std::size_t results, microseconds time, microseconds tick) {
  Range range{.lowest = 0};
  if (tick > microseconds{0}) range.highest = 1 / results::in_minutes(tick);
  if (time > microseconds{0}) range.step = static_cast<double>(results) / results::in_minutes(time);
  return range;
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
  const auto statistic = [&](std::optional<double> (results::FalseAlarms::*rate)() const) -> Statistic {
    return [sum_of, rate](const RunsByObject& chosen) { return (sum_of(chosen).*rate)(); };
  };
  results::FalseAlarmTable table;
  for (const RunFalseAlarms& run : runs) table.total += run.counts;
  const results::FalseAlarms& total = table.total;
  const auto range_of = [&total](std::size_t results, microseconds time) { return range_of_rates(results, time, total.tick); };
  for (const auto& [name, cells] : objects) {
    const results::FalseAlarms of = sum_of({indexes_of(cells)});
    results::Figure& of_object = table.objects[name];
    of_object = figure_of_object(cells, statistic(&results::FalseAlarms::per_min), options, range_of(cells.size(), of.none_time));
    widen_by_few_alarms(of_object, of, options.confidence, most_results_of_a_run({cells}));
  }
  const CrossedResults with_none = without_names(objects);
  table.per_min = figure_over_objects(with_none, statistic(&results::FalseAlarms::per_min), options,
                                      range_of(result_count(with_none), total.none_time));
  widen_by_few_alarms(table.per_min, total, options.confidence, most_results_of_a_run(with_none));
  const CrossedResults all = without_names(results_by_object(runs, [](const RunFalseAlarms&) { return true; }));
  const auto per_min = [&](auto rate, std::uint64_t alarms, microseconds time) {
    results::Figure figure = figure_over_objects(all, statistic(rate), options, range_of(result_count(all), time));
    widen_by_few_alarms(figure, alarms, time, options.confidence, most_results_of_a_run(all));
    return figure;
  };
  table.outside_labels_per_min =
      per_min(&results::FalseAlarms::outside_labels_per_min, total.outside_labels, total.outside_labels_time);
  table.outside_motion_per_min =
      per_min(&results::FalseAlarms::outside_motion_per_min, total.outside_motion, total.outside_motion_time);
  const auto share = [&](auto of_time) { return figure_over_objects(all, statistic(of_time), options, {0, 1, 1}); };
  table.outside_labels_share = share(&results::FalseAlarms::outside_labels_share);
  table.outside_motion_share = share(&results::FalseAlarms::outside_motion_share);
  table.none_in_alarm_share = share(&results::FalseAlarms::none_in_alarm_share);
  table.wrong_class_share = share(&results::FalseAlarms::wrong_class_share);
  table.wrong_class_per_min = per_min(&results::FalseAlarms::wrong_class_per_min, total.wrong_class, total.labelled_time);
  return table;
}

}  // namespace tactile::evaluation
