#pragma once

#include <span>
#include <string>

#include "tactile/experiments/trade/plan_trade.hpp"

namespace tactile::trade {

/// Whether there is evidence for another default, in sentences: how probable it is that the usual setting is on each front,
/// which settings are better by the whole intervals of their differences, and if there is none, the most accurate of the faster
/// ones.
///
/// A setting is better if it is faster in half and in 99 % of the ticks, and worse at most by a margin in all else: accuracy and
/// misses by one point, the median delay by 1 ms, false alarms by one a minute. The dense pass is for comparison only. A setting
/// is tested if both have five trainings and each difference an interval; the sentences count those that are not.
/// @param points  judged, the usual setting first
/// @return  nothing if there is no other setting
std::string judgement_of_usual(std::span<const TradePoint> points, const TradeSetting& usual);

}  // namespace tactile::trade
