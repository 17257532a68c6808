#pragma once

#include <map>
#include <span>
#include <string>

#include "tactile/experiments/trade/measure_points.hpp"

namespace tactile::trade {

/// Computes all figures of the points, which are on a front, and how probable that is.
/// @param measured  with predictions of all networks of the points, and times of all points
void judge(const TradePlan& plan, MeasuredPoints& measured);

/// The outcomes on the runs to choose on, by `id_of`; points with an unknown figure are left out.
std::map<std::string, TradeOutcome> known_outcomes(std::span<const TradePoint> points);

}  // namespace tactile::trade
