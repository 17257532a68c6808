#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/experiments/trade/tick_quantiles.hpp"
#include "tactile/experiments/trade/tick_times.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::trade {

/// A run that detectors are judged on.
struct JudgedRun {
  RunFolder folder;
  std::string events_sha256;
  std::vector<windows::Sample> samples;  ///< balanced, ascending in time; none of a run that the dataset has none of
  evaluation::RunTruth truth;
};

/// A run judged for one training's detector. The time of a touch is t_c(k) - onset, without the time to compute.
/// A balanced sample gets the verdict of the last tick up to it; none before the first tick.
/// @param full  the run at the setting's tick
results::Cell cell_of(const JudgedRun& run, const results::FullRun& full, std::span<const Touch> verdicts);

/// The durations of a run's ticks.
TimedRun timed_run(const JudgedRun& run, std::span<const TickTime> times);

/// The figures of a setting. Times per tick are quantiles of all ticks of the timed runs together.
/// @param cells  of every training
/// @param timed  with the network of one training
results::TradeResult result_of(std::span<const results::Cell> cells, std::span<const TimedRun> timed,
                               const results::BootstrapOptions& options = {});

}  // namespace tactile::trade
