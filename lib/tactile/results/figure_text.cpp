#include "tactile/results/figure_text.hpp"

#include <fmt/core.h>

#include <cmath>

namespace tactile::results {

std::string value_text(const Figure& figure, double scale, int decimals) {
  return std::isfinite(figure.value) ? fmt::format("{:.{}f}", scale * figure.value, decimals) : "-";
}

std::string interval_text(const Figure& figure, double scale, int decimals) {
  if (!std::isfinite(figure.value) || (!figure.low && !figure.high)) return "";
  const auto bound = [&](const std::optional<double>& value) {
    return value ? fmt::format("{:.{}f}", scale * *value, decimals) : "?";
  };
  return fmt::format("[{}, {}]", bound(figure.low), bound(figure.high));
}

std::string figure_text(const Figure& figure, double scale, int decimals) {
  const std::string value = value_text(figure, scale, decimals), interval = interval_text(figure, scale, decimals);
  return interval.empty() ? value : value + " " + interval;
}

}  // namespace tactile::results
