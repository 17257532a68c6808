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

namespace {

/// The probability that a variable of the beta distribution is below x: the incomplete beta function, as a continued fraction by
/// the method of Lentz.
double beta_probability(double a, double b, double x) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - beta_probability(b, a, 1 - x);
  constexpr double tiny = 1e-300;
  const auto or_tiny = [](double value) { return std::abs(value) < tiny ? tiny : value; };
  double c = 1, d = 1 / or_tiny(1 - (a + b) * x / (a + 1)), fraction = d, change = 0;
  for (int step = 1; step < 100'000 && std::abs(change - 1) > 1e-13; ++step) {
    const double m = step;
    for (const double term :
         {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)), -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 / or_tiny(1 + term * d);
      c = or_tiny(1 + term / c);
      fraction *= change = c * d;
    }
  }
  return std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) * fraction / a;
}

double beta_quantile(double a, double b, double probability) {
  double low = 0, high = 1;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (beta_probability(a, b, middle) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

std::pair<double, double> binomial_bounds(double count, double n, double confidence) {
  const double outside = (1 - confidence) / 2;
  return {count <= 0 ? 0 : beta_quantile(count, n - count + 1, outside),
          count >= n ? 1 : beta_quantile(count + 1, n - count, 1 - outside)};
}

}  // namespace tactile::evaluation
