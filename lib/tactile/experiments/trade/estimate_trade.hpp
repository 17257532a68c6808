#pragma once

#include "tactile/experiments/estimate.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"

namespace tactile::trade {

/// What `run_trade` would do with these options and without a budget. Which combinations it tries, and which settings it trains
/// more than once, depends on what it finds: these parts say "at most". Measures this machine's speed in training, for a second
/// per size of network; writes nothing. The times are estimates, as those of `study::estimate_study`.
/// @throws Error  as `run_trade`, or if there is no dataset
experiments::Estimate estimate_trade(const TradeOptions& options);

}  // namespace tactile::trade
