#pragma once

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::report {

// The marks of settings are those of `dots_plot`. The front was found on the choice runs by two or three figures. On the reported
// runs it need not be a front, so no line joins it.

/// Accuracy against the 99th percentile of the time per tick, by its logarithm.
pictures::Plot trade_accuracy_plot(const results::Trade& trade);

/// Median delay, misses later than all others, against false alarms per minute outside of touches. Both axes are linear near
/// 0 and logarithmic beyond: log10(x + 1), with the delay in ms. An interval without meaningful bounds is left out.
pictures::Plot trade_delay_plot(const results::Trade& trade);

}  // namespace tactile::report
