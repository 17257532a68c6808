#include "tactile/experiments/trade/trade_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::trade {
namespace {

using Runs = std::span<const TradedRun>;
using OfRuns = std::function<std::optional<double>(const evaluation::RunsByObject&)>;

OfRuns accuracy_in(Runs runs) {
  return evaluation::mean_over_objects([runs](std::span<const std::size_t> indexes) {
    results::Confusion sum;
    for (const std::size_t i : indexes) sum += runs[i].confusion;
    return sum.accuracy();
  });
}

/// The durations of the ticks of a setting, sorted once for all draws.
struct Times {
  explicit Times(std::span<const TimedRun> timed)
      : all(timed, &TimedRun::tick_us),
        open(timed, &TimedRun::open_tick_us),
        runs(evaluation::without_names(evaluation::results_by_object(timed, [](const TimedRun&) { return true; }))) {}

  OfRuns us(double q) const {
    return [this, q](const evaluation::RunsByObject& chosen) { return all.of(chosen, q); };
  }

  /// The median over ticks whose gate is open; over all ticks if it is open at none; NaN if none was timed.
  double computing_us() const {
    const evaluation::RunsByObject everything = evaluation::all_of(runs);
    const auto of_open = open.of(everything, 0.5);
    return (of_open ? of_open : all.of(everything, 0.5)).value_or(std::numeric_limits<double>::quiet_NaN());
  }

  TickQuantiles all, open;
  evaluation::CrossedResults runs;
};

std::vector<TradedDelay> delays_in(Runs runs, const evaluation::RunsByObject& chosen) {
  std::vector<TradedDelay> delays;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) delays.insert(delays.end(), runs[i].delays.begin(), runs[i].delays.end());
  }
  return delays;
}

/// Over all presses and slips: those that were not detected count with their limit.
OfRuns delay_in(Runs runs, double q) {
  return [runs, q](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    std::vector<double> us;
    for (const TradedDelay& delay : delays_in(runs, chosen)) us.push_back(delay.us);
    return us.empty() ? std::nullopt : std::optional(quantile(us, q));
  };
}

OfRuns mean_delay_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    double sum = 0, count = 0;
    for (const TradedDelay& delay : delays_in(runs, chosen)) {
      if (delay.detected) sum += delay.us, ++count;
    }
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  };
}

OfRuns missed_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    const std::vector<TradedDelay> delays = delays_in(runs, chosen);
    if (delays.empty()) return std::nullopt;
    const auto missed = std::count_if(delays.begin(), delays.end(), [](const TradedDelay& delay) { return !delay.detected; });
    return static_cast<double>(missed) / static_cast<double>(delays.size());
  };
}

/// Over objects; over trainings and the runs of these objects where they are too few to be drawn from.
results::Figure figure_over(const evaluation::CrossedResults& all, const OfRuns& statistic,
                            const results::BootstrapOptions& options, const evaluation::Range& range) {
  return all.size() < fewest_objects ? evaluation::figure_of_these_objects(all, statistic, options, range)
                                     : evaluation::figure_over_objects(all, statistic, options, range);
}

using CountsOf = results::FalseAlarms (*)(const results::FalseAlarms&);

results::FalseAlarms none_time_only(const results::FalseAlarms& counts) { return counts; }

OfRuns per_min_in(Runs runs, CountsOf counts_of) {
  return [runs, counts_of](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    results::FalseAlarms sum;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) sum += counts_of(runs[i].alarms);
    }
    return sum.per_min();
  };
}

evaluation::CrossedResults all_by_object(Runs runs) {
  return evaluation::without_names(evaluation::results_by_object(runs, [](const TradedRun&) { return true; }));
}

/// For few alarms, or little time, the interval over runs is too narrow. Several trainings on one run see the
/// same time, which counts once.
void widen_by_few_alarms_in(Runs runs, CountsOf counts_of, results::Figure& per_min, double confidence) {
  results::FalseAlarms sum;
  for (const TradedRun& run : runs) sum += counts_of(run.alarms);
  evaluation::widen_by_few_alarms(per_min, sum, confidence, evaluation::most_results_of_a_run(all_by_object(runs)));
}

/// The values that figures of these runs may have, in steps of one sample, one interval, one alarm, and the shortest delay.
struct Ranges {
  evaluation::Range accuracy{.lowest = 0, .highest = 1}, missed = accuracy, per_min{};
  evaluation::Range delay{.lowest = 0, .highest = static_cast<double>(evaluation::DelayOptions{}.window.count())};  ///< [us]
};

Ranges ranges_of(Runs runs) {
  Ranges ranges;
  double samples = 0, intervals = 0, shortest = std::numeric_limits<double>::infinity();
  results::FalseAlarms outside;
  for (const TradedRun& run : runs) {
    samples += static_cast<double>(run.confusion.samples());
    intervals += static_cast<double>(run.delays.size());
    outside += run.alarms;
    for (const TradedDelay& delay : run.delays) shortest = delay.us > 0 ? std::min(shortest, delay.us) : shortest;
  }
  const auto per_run = [&](double units) { return units > 0 ? static_cast<double>(runs.size()) / units : 0; };
  ranges.accuracy.step = per_run(samples);
  ranges.missed.step = per_run(intervals);
  ranges.per_min = evaluation::range_of_rates(runs.size(), outside.outside_labels_time, outside.tick);
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

TradedRun outcome_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts) {
  TradedRun outcome;
  outcome.object = run.object;
  outcome.run = run.run;
  const TickRange& ticks = full.ticks;
  for (const windows::Sample& sample : run.samples) {
    const CameraTime tick = last_tick_until(sample.t, ticks.tick);
    const std::int64_t place = ticks.count > 0 && tick >= ticks.first ? between(ticks.first, tick) / ticks.tick : -1;
    const bool is_predicted = place >= 0 && ticks.count > 0;
    outcome.confusion.add(sample.touch,
                          is_predicted ? verdicts[static_cast<std::size_t>(std::min(place, ticks.count - 1))] : Touch::none);
  }
  const auto detections = evaluation::detections_of(ticks, verdicts, run.truth.used());
  for (const results::Detection& detection : detections) {
    const bool detected = detection.outcome == results::DetectionOutcome::detected;
    if (detection.outcome == results::DetectionOutcome::missed) ++outcome.misses;
    if (detection.outcome == results::DetectionOutcome::early) ++outcome.early;
    const microseconds delay = detected ? between(detection.interval.start, detection.first_right) : detection.limit;
    outcome.delays.push_back({static_cast<double>(delay.count()), detected});
  }
  const std::vector<TouchInterval> labelled = run.truth.all_labelled();
  if (!labelled.empty())
    outcome.alarms =
        evaluation::false_alarms_of(ticks, verdicts, {labelled, run.truth.releases, run.truth.unlabelled, run.guard}, detections);
  return outcome;
}

TimedRun timed_run(const JudgedRun& run, std::span<const TickTime> times, std::optional<model::GateRule> gate) {
  TimedRun timed;
  timed.object = run.object;
  timed.run = run.run;
  for (const TickTime& time : times) {
    timed.tick_us.push_back(static_cast<float>(time.total(gate)));
    if (time.is_open(gate)) timed.open_tick_us.push_back(timed.tick_us.back());
    timed.interrupted += time.interruptions > 0 ? 1 : 0;
  }
  return timed;
}

results::FalseAlarms outside_labels(const results::FalseAlarms& counts) {
  results::FalseAlarms all;
  all.alarms = counts.outside_labels;
  all.none_time = counts.outside_labels_time;
  return all;
}

namespace {

/// Whether one that was not detected lies at or below a quantile: the true one may be higher.
bool is_bound(Runs runs, const results::Figure& figure) {
  return std::any_of(runs.begin(), runs.end(), [&](const TradedRun& run) {
    return std::any_of(run.delays.begin(), run.delays.end(),
                       [&](const TradedDelay& delay) { return !delay.detected && delay.us <= figure.value; });
  });
}

void add_counts(Runs runs, results::TradeResult& result) {
  for (const TradedRun& run : runs) {
    result.intervals += run.delays.size();
    result.misses += run.misses;
    result.early += run.early;
    result.alarms += run.alarms.alarms;
    result.episodes += outside_labels(run.alarms).alarms;
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
  figures.accuracy = figure(accuracy_in(runs), ranges.accuracy);
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
  figures.episodes_per_min = figure(per_min_in(runs, outside_labels), ranges.per_min);
  widen_by_few_alarms_in(runs, outside_labels, figures.episodes_per_min, options.confidence);
  result.false_alarms_per_min = figure(per_min_in(runs, none_time_only), ranges.per_min);
  widen_by_few_alarms_in(runs, none_time_only, result.false_alarms_per_min, options.confidence);
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
      .accuracy = over(all, accuracy_in(a.runs), accuracy_in(b.runs), both_ways(ranges.accuracy)),
      .delay_us = over(all, delay_in(a.runs, 0.5), delay_in(b.runs, 0.5), both_ways(ranges.delay)),
      .missed = over(all, missed_in(a.runs), missed_in(b.runs), both_ways(ranges.missed)),
      .episodes_per_min =
          over(all, per_min_in(a.runs, outside_labels), per_min_in(b.runs, outside_labels), both_ways(ranges.per_min)),
      .us_p50 = over(of_a.runs, of_a.us(0.5), of_b.us(0.5), {}),
      .us_p99 = over(of_a.runs, of_a.us(0.99), of_b.us(0.99), {})};
  add_to(difference.delay_us, of_b.computing_us() - of_a.computing_us());
  return difference;
}

}  // namespace tactile::trade
