#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/study/step_runner.hpp"
#include "tactile/trade/trade.hpp"
#include "tactile/trade/trade_point.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// All that a trade has found. Everything is viewed.
struct TradeFindings {
  const TradeOptions& options;
  const Dataset& dataset;
  unsigned threads = 1;                                    ///< used
  std::span<const std::uint32_t> train, choice, reported;  ///< runs
  std::span<const TradePoint> points;                      ///< the usual one first
  std::span<const NotMeasured> not_measured;
  const nlohmann::json& growth;          ///< null where it was not measured
  const nlohmann::json& recommendation;  ///< as trade.json has it
  std::string unfinished;                ///< what the budget left undone, in a sentence; empty if nothing
  std::span<const StepRecord> steps;
};

/// What trade.json holds; docs/format.md lists its keys.
nlohmann::json trade_json(const TradeFindings& findings);

/// Writes trade.csv and trade.json, each whole or not at all. @param trade  as trade.json has it
void write_trade(const nlohmann::json& trade, const std::filesystem::path& folder);

/// One row for each setting and set of runs. @param trade  as trade.json has it
std::string trade_csv(const nlohmann::json& trade);

}  // namespace tactile
