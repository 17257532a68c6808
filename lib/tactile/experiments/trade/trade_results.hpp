#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/trade/plan_trade.hpp"
#include "tactile/results/step_record.hpp"

namespace tactile::trade {

/// All that was measured. Everything is viewed.
struct TradeFindings {
  std::span<const TradePoint> points;  ///< the usual setting first
  std::span<const NotMeasured> not_measured;
  const nlohmann::json& growth;          ///< null if it was not measured
  const nlohmann::json& recommendation;  ///< as in trade.json
  std::string unfinished;                ///< a sentence if the budget ended the work; else empty
  std::span<const results::StepRecord> steps;
};

/// The contents of trade.json; docs/format/ lists its keys.
nlohmann::json trade_json(const TradePlan& plan, const TradeFindings& findings);

/// Writes trade.csv and trade.json, each complete or not at all. @param trade  the contents of trade.json
void write_trade(const nlohmann::json& trade, const std::filesystem::path& folder);

/// One row for each setting and set of runs. @param trade  the contents of trade.json
std::string trade_csv(const nlohmann::json& trade);

}  // namespace tactile::trade
