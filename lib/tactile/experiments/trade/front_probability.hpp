#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/trade/trade_figures.hpp"

namespace tactile::trade {

/// "on the front of accuracy and time in 62 % of the draws of trainings, objects and runs, and on that of …"; empty if unknown.
std::string text_of(const results::FrontProbability& probability);

/// What the fronts are found by: outcomes on the runs to choose on, and times.
struct FrontCandidate {
  std::vector<results::Cell> runs;
  std::vector<TimedRun> timed;
};

/// Whether each candidate is on the front of accuracy and time, and on the front of false alarms, delay and misses.
struct OnFronts {
  std::vector<bool> accuracy, delay;
};
OnFronts fronts_of(std::span<const results::TradeResult> figures);

/// The share of draws in which each candidate is on a front. A draw takes trainings, objects, and runs of each object with
/// replacement, the same ones for all candidates with the same number of trainings. Times depend on objects and runs alone.
/// @param options  `confidence` is not used
std::vector<results::FrontProbability> front_probabilities(std::span<const FrontCandidate> candidates, unsigned threads,
                                                           const results::BootstrapOptions& options = {});

}  // namespace tactile::trade
