#include "tactile/evaluation/confidence_interval.hpp"

#include <cmath>

namespace tactile::evaluation {

Statistic mean_over_objects(std::function<std::optional<double>(std::span<const std::size_t>)> of_object) {
  return [of_object = std::move(of_object)](const RunsByObject& runs) -> std::optional<double> {
    double sum = 0;
    std::size_t objects = 0;
    for (const auto& object : runs) {
      const auto value = of_object(object);
      if (!value) continue;
      sum += *value;
      ++objects;
    }
    if (objects == 0) return std::nullopt;
    return sum / static_cast<double>(objects);
  };
}

double poisson_upper_bound(std::uint64_t count, double confidence) {
  const double share = (1 - confidence) / 2;
  // No mean asked for lies below the count, so from there on down each term is less than the one before.
  const auto share_up_to_count = [count](double mean) {
    auto k = static_cast<double>(count);
    double term = std::exp(k * std::log(mean) - mean - std::lgamma(k + 1)), sum = term;
    for (; k > 0 && term > 1e-17 * sum; --k) sum += term *= k / mean;
    return sum;
  };
  double low = static_cast<double>(count), high = low + 10;
  while (share_up_to_count(high) > share) high *= 2;
  if (low == 0) low = 1e-9;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (share_up_to_count(middle) > share ? low : high) = middle;
  }
  return high;
}

}  // namespace tactile::evaluation
