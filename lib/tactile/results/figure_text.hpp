#pragma once

#include <string>

#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

// Figures in tables and sentences. `scale` is 100 for percent.

/// "94.6"; "-" without a value.
std::string value_text(const Figure& figure, double scale, int decimals);

/// "[91.3, 96.7]"; an unknown bound is "?". Empty without an interval.
std::string interval_text(const Figure& figure, double scale, int decimals);

/// "94.6 [91.3, 96.7]", or only the value.
std::string figure_text(const Figure& figure, double scale, int decimals);

/// "94.6 % [91.3, 96.7]" of a share.
std::string percent_text(const Figure& share);

/// "6"; "> 500" where only a bound is known.
std::string value_text(const CensoredQuantile& quantile, int decimals = 0);

/// "6 [5, 8]"
std::string figure_text(const CensoredQuantile& quantile, int decimals = 0);

}  // namespace tactile::results
