#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/trade/plan_trade.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::trade {

/// All that was measured. `points` is viewed.
struct TradeFindings {
  std::span<const TradePoint> points;  ///< the usual setting first
  std::vector<results::NotMeasured> not_measured;
  results::TradeRecommendation recommendation;
  std::string unfinished;  ///< a sentence if the budget ended the work; else empty
  std::vector<results::StepRecord> steps;
};

results::Trade results_of(const TradePlan& plan, TradeFindings findings);

/// Writes trade.csv and trade.json, each complete or not at all.
void write_trade(const results::Trade& trade, const std::filesystem::path& folder);

/// One row for each setting and set of runs.
std::string trade_csv(const results::Trade& trade);

}  // namespace tactile::trade
