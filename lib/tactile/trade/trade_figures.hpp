#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/false_alarms.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/trade/full_runs.hpp"
#include "tactile/trade/recommendation.hpp"
#include "tactile/trade/tick_times.hpp"

namespace tactile {

/// What a run holds to judge a detector by.
struct JudgedRun {
  std::string run, object;
  std::vector<Sample> samples;  ///< balanced, ascending in time
  RunTruth truth;
  microseconds guard{100'000};  ///< after an interval, alarms are counted apart for so long
};

/// What a detector did in one run; of several seeds all together.
struct TradedRun {
  std::string object;
  Confusion confusion;
  std::vector<double> delays_us;  ///< of the detected presses and slips: t_c(k) - onset, without computing
  std::uint64_t intervals = 0, misses = 0, early = 0;
  FalseAlarms alarms;
  std::vector<double> tick_us;       ///< what ticks took
  std::vector<double> open_tick_us;  ///< of these, those that no gate closed
  unsigned seeds = 1;

  TradedRun& operator+=(const TradedRun& other);  ///< a seed more; times stay
};

/// A balanced sample takes the verdict of the last tick up to it; none before the first.
/// @param full  at the setting's tick
TradedRun outcome_of(const JudgedRun& run, const FullRun& full, std::span<const Touch> verdicts);

/// Adds what ticks took, the gate's way where it closes.
void add_times(TradedRun& outcome, std::span<const TickTime> times, std::optional<std::uint64_t> gate);

/// All figures over the same runs, as one wants them told; a delay includes computing: the median time of a tick that no gate
/// closes, as every tick is at which something is detected. The interval of false alarms is
/// widened by few alarms.
struct TradeResult {
  TradeFigures figures;
  Figure delay_p95_us;
  Figure missed;  ///< share of presses and slips missed or early, in [0, 1]
  std::uint64_t intervals = 0, misses = 0, early = 0, alarms = 0;
};

void to_json(nlohmann::json& json, const TradeResult& result);

TradeResult result_of(std::span<const TradedRun> runs, const BootstrapOptions& options = {});

/// `b - a` of the same runs in the same order, in each draw too.
struct TradeDifference {
  Figure accuracy, delay_us, false_alarms_per_min, us_p50, us_p99;
};

void to_json(nlohmann::json& json, const TradeDifference& difference);

/// @throws Error  if they are not of the same objects
TradeDifference difference_of(std::span<const TradedRun> a, std::span<const TradedRun> b, const BootstrapOptions& options = {});

}  // namespace tactile
