#include "tactile/experiments/trade/trade_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/whole_runs.hpp"

namespace tactile::trade {
namespace {

using Runs = std::span<const results::Cell>;
using OfRuns = std::function<std::optional<double>(const evaluation::RunsByObject&)>;

OfRuns accuracy_in(Runs runs) {
  return evaluation::mean_over_objects([runs](std::span<const std::size_t> indexes) {
    results::Confusion sum;
    for (const std::size_t i : indexes) sum += runs[i].samples;
    return sum.accuracy();
  });
}

/// The durations of the ticks of a setting, sorted once for all draws.
struct Times {
  explicit Times(std::span<const TimedRun> timed)
      : all(timed), runs(evaluation::without_names(evaluation::results_by_object(timed, [](const TimedRun&) { return true; }))) {}

  OfRuns us(double q) const {
    return [this, q](const evaluation::RunsByObject& chosen) { return all.of(chosen, q); };
  }

  /// The median; NaN if no tick was timed.
  double computing_us() const { return all.of(evaluation::all_of(runs), 0.5).value_or(std::numeric_limits<double>::quiet_NaN()); }

  TickQuantiles all;
  evaluation::CrossedResults runs;
};

bool is_detected(const results::TouchOutcome& touch) { return touch.outcome == results::DetectionOutcome::detected; }

std::vector<results::TouchOutcome> touches_in(Runs runs, const evaluation::RunsByObject& chosen) {
  std::vector<results::TouchOutcome> touches;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) touches.insert(touches.end(), runs[i].touches.begin(), runs[i].touches.end());
  }
  return touches;
}

/// Over all presses and slips: those that were not detected count with their limit.
OfRuns delay_in(Runs runs, double q) {
  return [runs, q](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    std::vector<double> us;
    for (const results::TouchOutcome& touch : touches_in(runs, chosen)) us.push_back(1000 * touch.ms);
    return us.empty() ? std::nullopt : std::optional(quantile(us, q));
  };
}

OfRuns mean_delay_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    double sum = 0, count = 0;
    for (const results::TouchOutcome& touch : touches_in(runs, chosen)) {
      if (is_detected(touch)) sum += 1000 * touch.ms, ++count;
    }
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  };
}

OfRuns missed_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    const std::vector<results::TouchOutcome> touches = touches_in(runs, chosen);
    if (touches.empty()) return std::nullopt;
    const auto detected = std::count_if(touches.begin(), touches.end(), is_detected);
    return 1 - static_cast<double>(detected) / static_cast<double>(touches.size());
  };
}

/// Over objects; over trainings and the runs of these objects where they are too few to be drawn from.
results::Figure figure_over(const evaluation::CrossedResults& all, const OfRuns& statistic,
                            const results::BootstrapOptions& options, const evaluation::Range& range) {
  return all.size() < fewest_objects ? evaluation::figure_of_these_objects(all, statistic, options, range)
                                     : evaluation::figure_over_objects(all, statistic, options, range);
}

OfRuns per_min_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    double alarms = 0, outside_s = 0;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) alarms += static_cast<double>(runs[i].alarm_count()), outside_s += runs[i].outside_s;
    }
    return outside_s > 0 ? std::optional(60 * alarms / outside_s) : std::nullopt;
  };
}

evaluation::CrossedResults all_by_object(Runs runs) {
  return evaluation::without_names(evaluation::results_by_object(runs, [](const results::Cell&) { return true; }));
}

/// Accuracy is of runs with balanced samples alone.
evaluation::CrossedResults sampled_by_object(Runs runs) {
  return evaluation::without_names(
      evaluation::results_by_object(runs, [](const results::Cell& run) { return run.samples.samples() > 0; }));
}

/// The values that figures of these runs may have, in steps of one sample, one interval, one alarm, and the shortest delay.
struct Ranges {
  evaluation::Range accuracy{.lowest = 0, .highest = 1}, missed = accuracy, per_min{};
  evaluation::Range delay{.lowest = 0, .highest = static_cast<double>(evaluation::DelayOptions{}.window.count())};  ///< [us]
};

Ranges ranges_of(Runs runs) {
  Ranges ranges;
  double samples = 0, intervals = 0, shortest = std::numeric_limits<double>::infinity();
  double outside_min = 0, tick_ms = std::numeric_limits<double>::infinity();
  for (const results::Cell& run : runs) {
    samples += static_cast<double>(run.samples.samples());
    intervals += static_cast<double>(run.touches.size());
    outside_min += run.outside_s / 60;
    tick_ms = std::min(tick_ms, run.tick_ms);
    for (const results::TouchOutcome& touch : run.touches)
      shortest = touch.ms > 0 ? std::min(shortest, 1000 * touch.ms) : shortest;
  }
  const auto per_run = [&](double units) { return units > 0 ? static_cast<double>(runs.size()) / units : 0; };
  ranges.accuracy.step = per_run(samples);
  ranges.missed.step = per_run(intervals);
  ranges.per_min = {.lowest = 0, .highest = 60'000 / tick_ms, .step = per_run(outside_min)};
  if (std::isfinite(shortest)) ranges.delay.step = shortest;
  return ranges;
}

/// The same of differences.
evaluation::Range both_ways(const evaluation::Range& range) { return {-range.highest, range.highest, range.step}; }

void add_to(results::Figure& figure, double more) {
  figure.value += more;
  if (figure.low) *figure.low += more;
  if (figure.high) *figure.high += more;
}

}  // namespace

results::Cell cell_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts) {
  const TickRange& ticks = full.ticks;
  results::Cell cell = evaluation::RunJudge(ticks, evaluation::course_of(run.truth)).judged(verdicts);
  cell.object = run.folder.object;
  cell.run = run.folder.run;
  for (const windows::Sample& sample : run.samples) {
    const CameraTime tick = last_tick_until(sample.t, ticks.tick);
    const std::int64_t place = ticks.count > 0 && tick >= ticks.first ? between(ticks.first, tick) / ticks.tick : -1;
    const bool is_predicted = place >= 0 && ticks.count > 0;
    cell.samples.add(sample.touch,
                     is_predicted ? verdicts[static_cast<std::size_t>(std::min(place, ticks.count - 1))] : Touch::none);
  }
  return cell;
}

TimedRun timed_run(const JudgedRun& run, std::span<const TickTime> times) {
  TimedRun timed;
  timed.object = run.folder.object;
  timed.run = run.folder.run;
  for (const TickTime& time : times) {
    timed.tick_us.push_back(static_cast<float>(time.total()));
    timed.interrupted += time.interruptions > 0 ? 1 : 0;
  }
  return timed;
}

namespace {

/// Whether one that was not detected lies at or below a quantile: the true one may be higher.
bool is_bound(Runs runs, const results::Figure& figure) {
  return std::any_of(runs.begin(), runs.end(), [&](const results::Cell& run) {
    return std::any_of(run.touches.begin(), run.touches.end(), [&](const results::TouchOutcome& touch) {
      return !is_detected(touch) && 1000 * touch.ms <= figure.value;
    });
  });
}

void add_counts(Runs runs, results::TradeResult& result) {
  for (const results::Cell& run : runs) {
    result.intervals += run.touches.size();
    for (const results::TouchOutcome& touch : run.touches) {
      result.misses += touch.outcome == results::DetectionOutcome::missed ? 1 : 0;
      result.early += touch.outcome == results::DetectionOutcome::early ? 1 : 0;
    }
    result.episodes += run.alarm_count();
  }
}

/// A quantile is not below one of a smaller share.
void raise_low(results::Figure& quantile, const results::Figure& of_smaller_share) {
  if (quantile.low && of_smaller_share.low) quantile.low = std::max(*quantile.low, *of_smaller_share.low);
}

}  // namespace

results::TradeResult result_of(Runs runs, std::span<const TimedRun> timed, const results::BootstrapOptions& options) {
  const evaluation::CrossedResults all = all_by_object(runs);
  const Times times(timed);
  const Ranges ranges = ranges_of(runs);
  const auto figure = [&](const OfRuns& statistic, const evaluation::Range& range) {
    return figure_over(all, statistic, options, range);
  };
  const auto of_times = [&](double q) { return figure_over(times.runs, times.us(q), options, {.lowest = 0}); };
  results::TradeResult result;
  results::TradeFigures& figures = result.figures;
  figures.accuracy = figure_over(sampled_by_object(runs), accuracy_in(runs), options, ranges.accuracy);
  figures.us_p50 = of_times(0.5);
  figures.us_p99 = of_times(0.99);
  figures.us_p999 = of_times(0.999);
  raise_low(figures.us_p99, figures.us_p50);
  raise_low(figures.us_p999, figures.us_p99);
  figures.delay_median_us = figure(delay_in(runs, 0.5), ranges.delay);
  figures.delay_p90_us = figure(delay_in(runs, 0.9), ranges.delay);
  figures.median_is_bound = is_bound(runs, figures.delay_median_us);
  figures.p90_is_bound = is_bound(runs, figures.delay_p90_us);
  result.delay_mean_us = figure(mean_delay_in(runs), ranges.delay);
  for (results::Figure* delay : {&figures.delay_median_us, &figures.delay_p90_us, &result.delay_mean_us})
    add_to(*delay, times.computing_us());
  figures.missed = figure(missed_in(runs), ranges.missed);
  if (!runs.empty()) figures.episodes_per_min = evaluation::operating_point(runs, options).alarms_per_min;
  add_counts(runs, result);
  double interrupted = 0;
  for (const TimedRun& run : timed) result.ticks += run.tick_us.size(), interrupted += static_cast<double>(run.interrupted);
  if (result.ticks > 0) figures.interrupted = interrupted / static_cast<double>(result.ticks);
  return result;
}

results::TradeDifference difference_of(const TradeOutcomes& a, const TradeOutcomes& b, const results::BootstrapOptions& options) {
  const auto is_same = [](const results::JudgedRun& one, const results::JudgedRun& other) {
    return one.object == other.object && one.run == other.run && one.training == other.training;
  };
  if (!std::equal(a.runs.begin(), a.runs.end(), b.runs.begin(), b.runs.end(), is_same) ||
      !std::equal(a.timed.begin(), a.timed.end(), b.timed.begin(), b.timed.end(), is_same))
    throw Error("difference of settings: the two are not of the same runs; expected the same runs in the same order");
  const auto over = [&](const evaluation::CrossedResults& all, const OfRuns& of_a, const OfRuns& of_b,
                        const evaluation::Range& range) {
    return figure_over(
        all,
        [&](const evaluation::RunsByObject& chosen) -> std::optional<double> {
          const auto first = of_a(chosen), second = of_b(chosen);
          if (!first || !second) return std::nullopt;
          return *second - *first;
        },
        options, range);
  };
  const evaluation::CrossedResults all = all_by_object(a.runs);
  const Ranges ranges = ranges_of(a.runs);
  const Times of_a(a.timed), of_b(b.timed);
  results::TradeDifference difference{
      .accuracy = over(sampled_by_object(a.runs), accuracy_in(a.runs), accuracy_in(b.runs), both_ways(ranges.accuracy)),
      .delay_us = over(all, delay_in(a.runs, 0.5), delay_in(b.runs, 0.5), both_ways(ranges.delay)),
      .missed = over(all, missed_in(a.runs), missed_in(b.runs), both_ways(ranges.missed)),
      .episodes_per_min = over(all, per_min_in(a.runs), per_min_in(b.runs), both_ways(ranges.per_min)),
      .us_p50 = over(of_a.runs, of_a.us(0.5), of_b.us(0.5), {}),
      .us_p99 = over(of_a.runs, of_a.us(0.99), of_b.us(0.99), {})};
  add_to(difference.delay_us, of_b.computing_us() - of_a.computing_us());
  return difference;
}

}  // namespace tactile::trade
