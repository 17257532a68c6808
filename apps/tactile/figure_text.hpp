#pragma once

#include <fmt/core.h>

#include <cmath>
#include <string>

#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::cli {

// Figures as cells of a table; "-" where there is none.

inline std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.2f}", value) : "-"; }
inline std::string number(const results::Figure& figure) { return number(figure.value); }
inline std::string percent(const results::Figure& figure) { return number(100 * figure.value); }

/// "[lower, upper]", both times `scale`.
inline std::string bounds(const results::Figure& figure, double scale) {
  return figure.low ? fmt::format("[{:.2f}, {:.2f}]", scale * *figure.low, scale * *figure.high) : "-";
}

inline std::string misses_and_early(const results::DelaySummary& delay) {
  return fmt::format("{} + {}", delay.misses, delay.early);
}

}  // namespace tactile::cli
