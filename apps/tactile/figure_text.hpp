#pragma once

#include <fmt/core.h>

#include <cmath>
#include <string>

#include "tactile/results/delay_table.hpp"
#include "tactile/results/figure_text.hpp"

namespace tactile::cli {

// Figures as cells of a table; "-" where there is none.

inline std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.2f}", value) : "-"; }
inline std::string number(const results::Figure& figure) { return results::value_text(figure, 1, 2); }
inline std::string percent(const results::Figure& figure) { return results::value_text(figure, 100, 2); }

/// "[lower, upper]", both times `scale`.
inline std::string bounds(const results::Figure& figure, double scale) {
  const std::string interval = results::interval_text(figure, scale, 2);
  return interval.empty() ? "-" : interval;
}

inline std::string misses_and_early(const results::DelaySummary& delay) {
  return fmt::format("{} + {}", delay.misses, delay.early);
}

}  // namespace tactile::cli
