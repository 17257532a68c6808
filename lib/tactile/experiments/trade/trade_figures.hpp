#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/false_alarms.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/experiments/trade/tick_times.hpp"

namespace tactile::trade {

/// The truth of a run, which detectors are judged by.
struct JudgedRun {
  std::string run, object;
  std::vector<windows::Sample> samples;  ///< balanced, ascending in time
  evaluation::RunTruth truth;
  microseconds guard{100'000};  ///< for this long after an interval, alarms are counted separately
};

/// The outcome of a detector in one run; of several seeds, the sum.
struct TradedRun : results::JudgedRun {
  results::Confusion confusion{};
  std::vector<double> delays_us{};  ///< of the detected presses and slips: t_c(k) - onset, without the time to compute
  std::uint64_t intervals = 0, misses = 0, early = 0;
  results::FalseAlarms alarms{};
  std::vector<double> tick_us{};       ///< duration of each tick
  std::vector<double> open_tick_us{};  ///< of these, the ones whose gate was open
  unsigned seeds = 1;

  TradedRun& operator+=(const TradedRun& other);  ///< adds another seed; times stay
};

/// A balanced sample gets the verdict of the last tick up to it; none before the first tick.
/// @param full  the run at the setting's tick
TradedRun outcome_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts);

/// Adds the durations of ticks; only those of counting if the gate closes.
void add_times(TradedRun& outcome, std::span<const TickTime> times, std::optional<std::uint64_t> gate);

/// All figures over the same runs. A delay includes the median time to compute a tick whose gate is open, as it is at each
/// detection. The interval of false alarms is wider if there are few alarms.
struct TradeResult {
  TradeFigures figures;
  results::Figure delay_p95_us;
  results::Figure missed;  ///< share of presses and slips missed or early, in [0, 1]
  std::uint64_t intervals = 0, misses = 0, early = 0, alarms = 0;
};

void to_json(nlohmann::json& json, const TradeResult& result);

TradeResult result_of(std::span<const TradedRun> runs, const results::BootstrapOptions& options = {});

/// `b - a` on the same runs in the same order, also in each draw of the bootstrap.
struct TradeDifference {
  results::Figure accuracy, delay_us, false_alarms_per_min, us_p50, us_p99;
};

void to_json(nlohmann::json& json, const TradeDifference& difference);

/// @throws Error  if they are not of the same objects
TradeDifference difference_of(std::span<const TradedRun> a, std::span<const TradedRun> b,
                              const results::BootstrapOptions& options = {});

}  // namespace tactile::trade
