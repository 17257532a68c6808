#pragma once

#include <cstdint>
#include <span>

#include "tactile/evaluation/run_figures.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/delay_table.hpp"

namespace tactile::evaluation {

/// Which delays: of all touches, of one class, or of slips from gross slip.
enum class Delay : std::uint8_t { all, press, slip, from_gross };

/// The least time within which the share `q` of the touches is detected. One that is not detected is later than all others; where
/// the quantile lies among them, it is their longest limit, and a lower bound.
/// @param figures  of these cells
results::CensoredQuantile delay_quantile(std::span<const results::Cell> cells, const RunFigures& figures, double q, Delay of);

/// Delays of one class over all cells, and of each object.
results::DelayTable delay_table(std::span<const results::Cell> cells, Touch touch, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
