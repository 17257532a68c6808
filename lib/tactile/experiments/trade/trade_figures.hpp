#pragma once

#include <cstdint>
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
#include "tactile/experiments/trade/tick_quantiles.hpp"
#include "tactile/experiments/trade/tick_times.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::trade {

/// To draw from them. With fewer objects, intervals are over trainings and runs, and hold for these objects only.
inline constexpr std::size_t fewest_objects = 3, fewest_runs = 3;

/// The truth of a run, which detectors are judged by.
struct JudgedRun {
  std::string run, object;
  std::vector<windows::Sample> samples;  ///< balanced, ascending in time
  evaluation::RunTruth truth;
  microseconds guard{100'000};  ///< for this long after an interval, alarms are counted separately
};

/// How long after the onset of a press or a slip its verdict came: t_c(k) - onset, without the time to compute. One that was
/// missed or early has its limit instead: min(end, start + 500 ms) - onset.
struct TradedDelay {
  double us = 0;
  bool detected = true;

  friend bool operator==(const TradedDelay&, const TradedDelay&) = default;
};

/// The outcome of one training's detector in one run.
struct TradedRun : results::JudgedRun {
  results::Confusion confusion{};
  std::vector<TradedDelay> delays{};  ///< one for each press and slip
  std::uint64_t misses = 0, early = 0;
  results::FalseAlarms alarms{};
};

/// A balanced sample gets the verdict of the last tick up to it; none before the first tick.
/// @param full  the run at the setting's tick
TradedRun outcome_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts);

/// The durations of a run's ticks; only those of counting if the gate closes.
TimedRun timed_run(const JudgedRun& run, std::span<const TickTime> times, std::optional<model::GateRule> gate);

/// The episodes outside labels as `alarms`, and the time outside labels as `none_time`: what one sees in a laboratory, where
/// releases and motion without labels are not known. A long episode counts again for each further 500 ms.
results::FalseAlarms outside_labels(const results::FalseAlarms& counts);

/// @param runs   of every training
/// @param timed  with the network of one training
results::TradeResult result_of(std::span<const TradedRun> runs, std::span<const TimedRun> timed,
                               const results::BootstrapOptions& options = {});

/// What a difference is taken of.
struct TradeOutcomes {
  std::span<const TradedRun> runs;
  std::span<const TimedRun> timed;
};

/// `b - a`, also in each draw of the bootstrap.
/// @throws Error  if they are not of the same trainings and runs in the same order
results::TradeDifference difference_of(const TradeOutcomes& a, const TradeOutcomes& b,
                                       const results::BootstrapOptions& options = {});

}  // namespace tactile::trade
