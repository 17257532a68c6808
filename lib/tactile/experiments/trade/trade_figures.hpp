#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/experiments/trade/tick_quantiles.hpp"
#include "tactile/experiments/trade/tick_times.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::trade {

/// To draw from them. With fewer objects, intervals are over trainings and runs, and hold for these objects only.
inline constexpr std::size_t fewest_objects = 3, fewest_runs = 3;

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

/// @param runs   of every training
/// @param timed  with the network of one training
results::TradeResult result_of(std::span<const results::Cell> runs, std::span<const TimedRun> timed,
                               const results::BootstrapOptions& options = {});

/// What a difference is taken of.
struct TradeOutcomes {
  std::span<const results::Cell> runs;
  std::span<const TimedRun> timed;
};

/// `b - a`, also in each draw of the bootstrap.
/// @throws Error  if they are not of the same trainings and runs in the same order
results::TradeDifference difference_of(const TradeOutcomes& a, const TradeOutcomes& b,
                                       const results::BootstrapOptions& options = {});

}  // namespace tactile::trade
