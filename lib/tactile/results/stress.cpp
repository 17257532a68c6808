#include "tactile/results/stress.hpp"

#include <fmt/core.h>

#include <cmath>

namespace tactile::results {

std::string words_of(const StressCurve& curve) {
  if (!curve.holds || curve.points.empty() || !std::isfinite(curve.holds->severity.value)) return "unknown";
  const Figure& severity = curve.holds->severity;
  const bool is_on_or_off = curve.unit.empty() && curve.points.size() == 2;
  if (is_on_or_off) return curve.holds->is_beyond ? "holds" : "does not hold";
  const std::string unit = curve.unit.empty() ? "" : " " + curve.unit;
  const auto number = [](double value) {
    return std::abs(value) >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
  };
  if (curve.holds->is_beyond) return fmt::format("beyond {}{}", number(curve.points.back().severity), unit);
  const std::string interval =
      severity.has_interval() ? fmt::format(" [{}, {}]", number(*severity.low), number(*severity.high)) : "";
  return fmt::format("up to {}{}{}", number(severity.value), unit, interval);
}

}  // namespace tactile::results
