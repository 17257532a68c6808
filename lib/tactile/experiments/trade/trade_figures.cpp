#include "tactile/experiments/trade/trade_figures.hpp"

#include <algorithm>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::trade {
namespace {

using Runs = std::span<const TradedRun>;
using OfRuns = std::function<std::optional<double>(const evaluation::RunsByObject&)>;

std::optional<double> quantile_of(const std::vector<double>& values, double q) {
  return values.empty() ? std::nullopt : std::optional(quantile(values, q));
}

std::vector<double> joined(Runs runs, const evaluation::RunsByObject& chosen, std::vector<double> TradedRun::*values) {
  std::vector<double> all;
  for (const auto& object : chosen) {
    for (const std::size_t i : object) all.insert(all.end(), (runs[i].*values).begin(), (runs[i].*values).end());
  }
  return all;
}

OfRuns accuracy_in(Runs runs) {
  return evaluation::mean_over_objects([runs](std::span<const std::size_t> indexes) {
    results::Confusion sum;
    for (const std::size_t i : indexes) sum += runs[i].confusion;
    return sum.accuracy();
  });
}

/// Of ticks whose gate is open; of all ticks if it is open at none.
OfRuns open_tick_us_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) {
    const auto open = quantile_of(joined(runs, chosen, &TradedRun::open_tick_us), 0.5);
    return open ? open : quantile_of(joined(runs, chosen, &TradedRun::tick_us), 0.5);
  };
}

OfRuns tick_us_in(Runs runs, double q) {
  return [runs, q](const evaluation::RunsByObject& chosen) { return quantile_of(joined(runs, chosen, &TradedRun::tick_us), q); };
}

OfRuns delay_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    const std::vector<double> delays = joined(runs, chosen, &TradedRun::delays_us);
    if (delays.empty()) return std::nullopt;
    double sum = 0;
    for (const double delay : delays) sum += delay;
    return sum / static_cast<double>(delays.size());
  };
}

OfRuns missed_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    std::uint64_t not_detected = 0, intervals = 0;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) not_detected += runs[i].misses + runs[i].early, intervals += runs[i].intervals;
    }
    if (intervals == 0) return std::nullopt;
    return static_cast<double>(not_detected) / static_cast<double>(intervals);
  };
}

OfRuns alarms_in(Runs runs) {
  return [runs](const evaluation::RunsByObject& chosen) -> std::optional<double> {
    results::FalseAlarms sum;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) sum += runs[i].alarms;
    }
    return sum.per_min();
  };
}

/// For few alarms, or little time, the bootstrap over runs gives too narrow an interval.
void widen_by_few_alarms_in(Runs runs, results::Figure& per_min, double confidence) {
  results::FalseAlarms sum;
  unsigned seeds = 1;
  for (const TradedRun& run : runs) sum += run.alarms, seeds = std::max(seeds, run.seeds);
  evaluation::widen_by_few_alarms(per_min, sum, confidence, seeds);
}

evaluation::CrossedResults all_by_object(Runs runs) {
  return evaluation::without_names(evaluation::results_by_object(runs, [](const TradedRun&) { return true; }));
}

void add_to(results::Figure& figure, double more) {
  figure.value += more;
  if (figure.low) *figure.low += more;
  if (figure.high) *figure.high += more;
}

}  // namespace

TradedRun& TradedRun::operator+=(const TradedRun& other) {
  confusion += other.confusion;
  delays_us.insert(delays_us.end(), other.delays_us.begin(), other.delays_us.end());
  intervals += other.intervals;
  misses += other.misses;
  early += other.early;
  alarms += other.alarms;
  seeds += other.seeds;
  return *this;
}

TradedRun outcome_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts) {
  TradedRun outcome;
  outcome.object = run.object;
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
    ++outcome.intervals;
    if (detection.outcome == results::DetectionOutcome::missed) ++outcome.misses;
    if (detection.outcome == results::DetectionOutcome::early) ++outcome.early;
    if (detection.outcome == results::DetectionOutcome::detected)
      outcome.delays_us.push_back(static_cast<double>(between(detection.interval.start, detection.first_right).count()));
  }
  const std::vector<TouchInterval> labelled = run.truth.all_labelled();
  if (!labelled.empty())
    outcome.alarms =
        evaluation::false_alarms_of(ticks, verdicts, {labelled, run.truth.releases, run.truth.unlabelled, run.guard}, detections);
  return outcome;
}

void add_times(TradedRun& outcome, std::span<const TickTime> times, std::optional<std::uint64_t> gate) {
  for (const TickTime& time : times) {
    outcome.tick_us.push_back(time.total(gate));
    if (!gate || time.events >= *gate) outcome.open_tick_us.push_back(time.total({}));
  }
}

void to_json(nlohmann::json& json, const TradeResult& result) {
  json = {{"accuracy", result.figures.accuracy},
          {"delay_us",
           {{"mean", result.figures.delay_us},
            {"p95", result.delay_p95_us},
            {"missed", result.missed},
            {"intervals", result.intervals},
            {"misses", result.misses},
            {"early", result.early}}},
          {"false_alarms_per_min", result.figures.false_alarms_per_min},
          {"false_alarms", result.alarms},
          {"us", {{"p50", result.figures.us_p50}, {"p99", result.figures.us_p99}}}};
}

TradeResult result_of(Runs runs, const results::BootstrapOptions& options) {
  const evaluation::CrossedResults all = all_by_object(runs);
  const auto figure = [&](const OfRuns& statistic) { return evaluation::figure_over_objects(all, statistic, options); };
  TradeResult result;
  result.figures.accuracy = figure(accuracy_in(runs));
  result.figures.us_p50 = figure(tick_us_in(runs, 0.5));
  result.figures.us_p99 = figure(tick_us_in(runs, 0.99));
  result.figures.delay_us = figure(delay_in(runs));
  result.figures.false_alarms_per_min = figure(alarms_in(runs));
  widen_by_few_alarms_in(runs, result.figures.false_alarms_per_min, options.confidence);
  result.delay_p95_us = figure(
      [runs](const evaluation::RunsByObject& chosen) { return quantile_of(joined(runs, chosen, &TradedRun::delays_us), 0.95); });
  result.missed = figure(missed_in(runs));
  const double computing_us = open_tick_us_in(runs)(evaluation::all_of(all)).value_or(std::numeric_limits<double>::quiet_NaN());
  add_to(result.figures.delay_us, computing_us);
  add_to(result.delay_p95_us, computing_us);
  for (const TradedRun& run : runs) {
    result.intervals += run.intervals;
    result.misses += run.misses;
    result.early += run.early;
    result.alarms += run.alarms.alarms;
  }
  return result;
}

void to_json(nlohmann::json& json, const TradeDifference& difference) {
  json = {{"accuracy", difference.accuracy},
          {"delay_us", difference.delay_us},
          {"false_alarms_per_min", difference.false_alarms_per_min},
          {"us", {{"p50", difference.us_p50}, {"p99", difference.us_p99}}}};
}

TradeDifference difference_of(Runs a, Runs b, const results::BootstrapOptions& options) {
  const bool same = std::equal(a.begin(), a.end(), b.begin(), b.end(),
                               [](const TradedRun& one, const TradedRun& other) { return one.object == other.object; });
  if (!same) throw Error("difference of settings: the two are not of the same objects; expected the same runs in the same order");
  const evaluation::CrossedResults all = all_by_object(a);
  const auto figure = [&](const OfRuns& of_a, const OfRuns& of_b) {
    return evaluation::figure_over_objects(
        all,
        [&](const evaluation::RunsByObject& chosen) -> std::optional<double> {
          const auto first = of_a(chosen), second = of_b(chosen);
          if (!first || !second) return std::nullopt;
          return *second - *first;
        },
        options);
  };
  const auto with_computing = [](const OfRuns& delay, const OfRuns& us) {
    return [=](const evaluation::RunsByObject& chosen) -> std::optional<double> {
      const auto found = delay(chosen);
      if (!found) return std::nullopt;
      return *found + us(chosen).value_or(0);
    };
  };
  return {.accuracy = figure(accuracy_in(a), accuracy_in(b)),
          .delay_us = figure(with_computing(delay_in(a), open_tick_us_in(a)), with_computing(delay_in(b), open_tick_us_in(b))),
          .false_alarms_per_min = figure(alarms_in(a), alarms_in(b)),
          .us_p50 = figure(tick_us_in(a, 0.5), tick_us_in(b, 0.5)),
          .us_p99 = figure(tick_us_in(a, 0.99), tick_us_in(b, 0.99))};
}

}  // namespace tactile::trade
