#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"

namespace tactile::trade {

/// Fifth stage: chooses a point that meets the constraints, on the runs to choose on, and measures it again on the reported runs.
/// @param points  judged, the usual setting first
/// @return  "recommendation" of trade.json   @throws Error  if the step fails
nlohmann::json recommend_setting(const TradePlan& plan, std::span<const TradePoint> points, experiments::StepRunner& runner);

}  // namespace tactile::trade
