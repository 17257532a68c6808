#pragma once

#include <span>

#include "tactile/experiments/trade/measure_points.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::trade {

/// Fourth stage: chooses a point that meets the constraints, on the runs to choose on, and runs it in `detect`.
/// @param points  judged, the usual setting first
/// @throws Error  if a step fails
results::TradeRecommendation recommend_setting(const Stage& stage, std::span<const TradePoint> points);

}  // namespace tactile::trade
