#pragma once

#include <optional>
#include <string>

#include "tactile/experiments/trade/measure_points.hpp"

namespace tactile::trade {

/// What a timed tick takes with the ticks to warm up, if nothing is known [us]; most settings take less.
inline constexpr double usual_tick_us = 600;

/// Times ticks of all points in one step, and keeps the times in `measured`. If the budget has no time for all points, it leaves
/// the usual one and those that are likeliest on a front; the others are moved to `not_measured`.
/// @param ticks  of each point, at least
/// @throws Error  if the budget has no time for the usual setting, or the step fails
void time_points(const Stage& stage, const std::string& step_name, std::uint64_t ticks, MeasuredPoints& measured);

/// The time that timing this many ticks of one setting takes, as far as it is known.
double timing_s(const Stage& stage, std::uint64_t ticks, const PointTimes& known);

}  // namespace tactile::trade
