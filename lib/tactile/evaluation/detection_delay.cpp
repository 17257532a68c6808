#include "tactile/evaluation/detection_delay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/evaluation/detection_curve.hpp"

namespace tactile::evaluation {
namespace {

/// The index of the first tick with t_c > t; below 0 where that lies before the range.
std::int64_t first_tick_after(CameraTime t, const TickRange& ticks) {
  const std::int64_t us = between(ticks.first, t).count(), tick_us = ticks.tick.count();
  const std::int64_t floor = us / tick_us - (us % tick_us < 0 ? 1 : 0);
  return floor + 1;
}

std::vector<double> delays_ms(std::span<const results::RunDetections> runs, const RunsByObject& chosen, Touch touch) {
  std::vector<double> delays;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) {
      for (const results::Detection& detection : runs[i].detections) {
        if (detection.interval.touch == touch && detection.outcome == results::DetectionOutcome::detected)
          delays.push_back(in_ms(detection.delay));
      }
    }
  }
  return delays;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Nothing for fewer than two values.
std::optional<double> standard_error_of(std::span<const double> values) {
  if (values.size() < 2) return std::nullopt;
  const double mean = mean_of(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const auto n = static_cast<double>(values.size());
  return std::sqrt(squares / (n - 1) / n);
}

/// The mean over trainings: those that are judged on the same intervals do not count them more than once.
double standard_error_of(std::span<const results::RunDetections> runs, const RunsByObject& chosen, Touch touch) {
  std::map<std::size_t, RunsByObject> of_trainings;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) of_trainings[runs[i].training].push_back({i});
  }
  std::vector<double> errors;
  for (const auto& of_training : of_trainings) {
    if (const auto error = standard_error_of(delays_ms(runs, of_training.second, touch))) errors.push_back(*error);
  }
  return mean_of(errors);
}

std::map<std::string, CrossedObject> runs_that_have(Touch touch, std::span<const results::RunDetections> runs) {
  return results_by_object(runs, [touch](const results::RunDetections& run) {
    return std::any_of(run.detections.begin(), run.detections.end(),
                       [touch](const results::Detection& d) { return d.interval.touch == touch; });
  });
}

/// The detections of one class in all runs, and the values that their figures may have.
struct TouchDetections {
  TouchDetections(std::span<const results::RunDetections> of, Touch its)
      : runs(of), touch(its), times(of, its), range(range_of_delays(of, its)), objects(runs_that_have(its, of)) {}

  std::span<const results::RunDetections> runs;
  Touch touch;
  DetectionTimes times;
  Range range;
  std::map<std::string, CrossedObject> objects;
};

template <class MakeFigure>
results::DelaySummary summary_of(const TouchDetections& of, const RunsByObject& chosen, MakeFigure make_figure) {
  results::DelaySummary summary;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) {
      for (const results::Detection& detection : of.runs[i].detections) {
        if (detection.interval.touch != of.touch) continue;
        ++summary.intervals;
        if (detection.outcome == results::DetectionOutcome::missed) ++summary.misses;
        if (detection.outcome == results::DetectionOutcome::early) ++summary.early;
        if (detection.outcome == results::DetectionOutcome::detected && detection.ahead) ++summary.head_starts;
      }
    }
  }
  summary.sem_ms = standard_error_of(of.runs, chosen, of.touch);
  const auto figure = [&](auto of_delays) {
    return make_figure(
        [&of, of_delays](const RunsByObject& drawn) -> std::optional<double> {
          auto delays = delays_ms(of.runs, drawn, of.touch);
          if (delays.empty()) return std::nullopt;
          return of_delays(std::move(delays));
        },
        of.range);
  };
  summary.mean_ms = figure([](const std::vector<double>& delays) { return mean_of(delays); });
  summary.median_ms = figure([](const std::vector<double>& delays) { return quantile(delays, 0.5); });
  summary.missed = make_figure([&of](const RunsByObject& drawn) { return of.times.missed_share(drawn); },
                               {0, 1, of.times.one_interval(result_count(without_names(of.objects)))});
  for (const auto& [q, of_all] : {std::pair(0.5, &summary.median_of_all_ms), std::pair(0.9, &summary.quantile_of_all_ms)}) {
    of_all->ms = make_figure(
        [&of, q = q](const RunsByObject& drawn) -> std::optional<double> {
          const auto found = of.times.quantile(drawn, q);
          return found ? std::optional(found->ms) : std::nullopt;
        },
        of.range);
    const auto found = of.times.quantile(chosen, q);
    of_all->is_lower_bound = found && found->is_lower_bound;
  }
  return summary;
}

/// Over all objects.
results::DelaySummary overall_summary(const TouchDetections& of, const results::BootstrapOptions& options) {
  const CrossedResults chosen = without_names(of.objects);
  return summary_of(of, all_of(chosen), [&](const Statistic& statistic, const Range& range) {
    return figure_over_objects(chosen, statistic, options, range);
  });
}

}  // namespace

std::vector<results::Detection> detections_of(const TickRange& ticks, std::span<const Touch> verdicts,
                                              std::span<const TouchInterval> intervals, const DelayOptions& options) {
  if (static_cast<std::int64_t>(verdicts.size()) != ticks.count) {
    throw Error("detection delay: " + std::to_string(verdicts.size()) + " verdicts for " + std::to_string(ticks.count) +
                " ticks; expected one for each");
  }
  const auto says = [&](std::int64_t index, Touch touch) {
    return index >= 0 && index < ticks.count && verdicts[static_cast<std::size_t>(index)] == touch;
  };
  std::vector<results::Detection> detections;
  for (const TouchInterval& interval : intervals) {
    results::Detection detection;
    detection.interval = interval;
    const CameraTime latest = std::min(interval.end, after(interval.start, options.window));
    detection.limit = std::max(between(interval.start, latest), microseconds{0});
    const std::int64_t k0 = first_tick_after(interval.start, ticks);
    if (says(k0 - 1, interval.touch) && says(k0, interval.touch)) {
      std::int64_t first = k0 - 1;
      while (says(first - 1, interval.touch)) --first;
      detection.leading_episode = first;
      if (ticks.tick * (k0 - first) > options.head_start) {
        detection.outcome = results::DetectionOutcome::early;
        detection.ahead = true;
        detections.push_back(detection);
        continue;
      }
    }
    for (std::int64_t k = std::max<std::int64_t>(k0, 0); k < ticks.count && ticks.at(k) <= latest; ++k) {
      if (!says(k, interval.touch)) continue;
      detection.outcome = results::DetectionOutcome::detected;
      detection.ahead = detection.leading_episode.has_value();
      detection.delay = ticks.tick * (k - k0 + 1);
      detection.first_right = ticks.at(k);
      break;
    }
    detections.push_back(detection);
  }
  return detections;
}

results::Detection counted_from(const results::Detection& detection, CameraTime onset, const TickRange& ticks) {
  results::Detection other = detection;
  const CameraTime latest = after(detection.interval.start, detection.limit);
  other.limit = std::max(between(onset, latest), microseconds{0});
  if (other.outcome != results::DetectionOutcome::detected) return other;
  const std::int64_t k = first_tick_after(detection.first_right, ticks) - 1;
  other.delay = ticks.tick * (k - first_tick_after(onset, ticks) + 1);
  return other;
}

Range range_of_delays(std::span<const results::RunDetections> runs, Touch touch) {
  Range range{.lowest = 0, .highest = 0};
  double shortest = std::numeric_limits<double>::infinity();
  for (const results::RunDetections& run : runs) {
    for (const results::Detection& detection : run.detections) {
      if (detection.interval.touch != touch) continue;
      range.highest = std::max({range.highest, in_ms(detection.limit), in_ms(detection.delay)});
      if (detection.outcome == results::DetectionOutcome::detected) shortest = std::min(shortest, in_ms(detection.delay));
    }
  }
  if (shortest <= 0) return {.highest = range.highest};
  if (std::isfinite(shortest)) range.step = shortest;
  return range;
}

std::vector<results::DetectedWithin> detected_within(std::span<const results::RunDetections> runs, Touch touch,
                                                     const results::BootstrapOptions& options) {
  const TouchDetections of(runs, touch);
  return detection_curve(of.times, without_names(of.objects), options);
}

results::DelaySummary delay_summary(std::span<const results::RunDetections> runs, Touch touch,
                                    const results::BootstrapOptions& options) {
  return overall_summary({runs, touch}, options);
}

results::DelayTable delay_table(std::span<const results::RunDetections> runs, Touch touch,
                                const results::BootstrapOptions& options) {
  const TouchDetections of(runs, touch);
  results::DelayTable table;
  for (const auto& [name, cells] : of.objects) {
    table.objects[name] = summary_of(of, {indexes_of(cells)}, [&, &own = cells](const Statistic& statistic, const Range& range) {
      return figure_of_object(own, statistic, options, range);
    });
  }
  table.all = overall_summary(of, options);
  table.curve = detection_curve(of.times, without_names(of.objects), options);
  return table;
}

results::Figure mean_delay_of_these_objects(std::span<const results::RunDetections> runs, Touch touch,
                                            const results::BootstrapOptions& options) {
  const TouchDetections of(runs, touch);
  const auto of_object = [&](std::span<const std::size_t> indexes) -> std::optional<double> {
    const auto delays = delays_ms(runs, {{indexes.begin(), indexes.end()}}, touch);
    return delays.empty() ? std::nullopt : std::optional(mean_of(delays));
  };
  return figure_of_these_objects(without_names(of.objects), mean_over_objects(of_object), options, of.range);
}

}  // namespace tactile::evaluation
