#include "tactile/experiments/trade/trade_figures.hpp"

#include <algorithm>

#include "tactile/core/ticks.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/whole_runs.hpp"

namespace tactile::trade {
namespace {

void add_to(results::Figure& figure, double more) {
  figure.value += more;
  if (figure.low) *figure.low += more;
  if (figure.high) *figure.high += more;
}

/// A quantile is not below one of a smaller share.
void raise_low(results::Figure& quantile, const results::Figure& of_smaller_share) {
  if (quantile.low && of_smaller_share.low) quantile.low = std::max(*quantile.low, *of_smaller_share.low);
}

void add_times(std::span<const TimedRun> timed, const results::BootstrapOptions& options, results::TradeResult& result) {
  const TickQuantiles ticks(timed);  // sorted once for all draws
  const evaluation::RunFigures figures(timed, &options, [](const TimedRun&) { return true; });
  const auto us = [&](double q) {
    return figures.of_all([&](const evaluation::RunsByObject& drawn) { return ticks.of(drawn, q); }, {.lowest = 0});
  };
  result.us_p50 = us(0.5);
  result.us_p99 = us(0.99);
  result.us_p999 = us(0.999);
  raise_low(result.us_p99, result.us_p50);
  raise_low(result.us_p999, result.us_p99);
  double interrupted = 0;
  for (const TimedRun& run : timed) result.ticks += run.tick_us.size(), interrupted += static_cast<double>(run.interrupted);
  if (result.ticks > 0) result.interrupted = interrupted / static_cast<double>(result.ticks);
}

}  // namespace

results::Cell cell_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts) {
  const TickRange& ticks = full.ticks;
  results::Cell cell = evaluation::RunJudge(ticks, evaluation::course_of(run.truth)).judged(verdicts);
  cell.world = run.truth.world;
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
  timed.world = run.truth.world;
  timed.object = run.folder.object;
  timed.run = run.folder.run;
  for (const TickTime& time : times) {
    timed.tick_us.push_back(static_cast<float>(time.total()));
    timed.interrupted += time.interruptions > 0 ? 1 : 0;
  }
  return timed;
}

results::TradeResult result_of(std::span<const results::Cell> cells, std::span<const TimedRun> timed,
                               const results::BootstrapOptions& options) {
  results::TradeResult result;
  add_times(timed, options, result);
  if (cells.empty()) return result;
  result.accuracy = evaluation::accuracy_of(cells, options).mean;
  result.whole_runs = evaluation::operating_point(cells, options);
  results::OperatingPoint& point = result.whole_runs;
  // A verdict is known once its tick is computed.
  for (results::CensoredQuantile* delay : {&point.median_ms, &point.p90_ms, &point.press_median_ms, &point.press_p90_ms,
                                           &point.slip_median_ms, &point.slip_p90_ms, &point.gross_median_ms})
    add_to(delay->ms, result.us_p50.value / 1000);
  return result;
}

}  // namespace tactile::trade
