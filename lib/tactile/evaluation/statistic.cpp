#include "tactile/evaluation/statistic.hpp"

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

std::pair<double, double> binomial_bounds(std::size_t count, std::size_t n, double confidence) {
  const auto at_least = [n](std::size_t least, double p) {
    double sum = 0;
    for (std::size_t k = least; k <= n; ++k) {
      const auto x = static_cast<double>(k), all = static_cast<double>(n);
      sum += std::exp(std::lgamma(all + 1) - std::lgamma(x + 1) - std::lgamma(all - x + 1) + x * std::log(p) +
                      (all - x) * std::log1p(-p));
    }
    return sum;
  };
  // The probability of at least `least` grows with p.
  const auto where = [&](std::size_t least, double probability) {
    double low = 0, high = 1;
    for (int step = 0; step < 60; ++step) {
      const double middle = (low + high) / 2;
      (at_least(least, middle) < probability ? low : high) = middle;
    }
    return (low + high) / 2;
  };
  const double share = (1 - confidence) / 2;
  return {count == 0 ? 0 : where(count, share), count == n ? 1 : where(count + 1, 1 - share)};
}

}  // namespace tactile::evaluation
