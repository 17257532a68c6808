#include "tactile/results/figure_text.hpp"

#include <fmt/core.h>

#include <cmath>

namespace tactile::results {
namespace {

/// Without the sign of a number that is rounded to 0.
std::string rounded(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  return text.find_first_not_of("-0.") == std::string::npos && text.front() == '-' ? text.substr(1) : text;
}

std::string with_interval(const std::string& value, const std::string& interval) {
  return interval.empty() ? value : value + " " + interval;
}

}  // namespace

std::string value_text(const Figure& figure, double scale, int decimals) {
  return std::isfinite(figure.value) ? rounded(scale * figure.value, decimals) : "-";
}

std::string interval_text(const Figure& figure, double scale, int decimals) {
  if (!std::isfinite(figure.value) || (!figure.low && !figure.high)) return "";
  const auto bound = [&](const std::optional<double>& value) { return value ? rounded(scale * *value, decimals) : "?"; };
  return fmt::format("[{}, {}]", bound(figure.low), bound(figure.high));
}

std::string figure_text(const Figure& figure, double scale, int decimals) {
  return with_interval(value_text(figure, scale, decimals), interval_text(figure, scale, decimals));
}

std::string percent_text(const Figure& share) {
  return with_interval(value_text(share, 100, 1) + " %", interval_text(share, 100, 1));
}

std::string value_text(const CensoredQuantile& quantile, int decimals) {
  return (quantile.is_lower_bound ? "> " : "") + value_text(quantile.ms, 1, decimals);
}

std::string figure_text(const CensoredQuantile& quantile, int decimals) {
  return (quantile.is_lower_bound ? "> " : "") + figure_text(quantile.ms, 1, decimals);
}

}  // namespace tactile::results
