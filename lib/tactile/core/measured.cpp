#include "tactile/core/measured.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace tactile {

Measured mean_of(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  const double mean = values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / n;
  if (values.size() < 2) return {mean, std::numeric_limits<double>::infinity()};
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

Measured ratio_of(std::span<const CountPart> parts) {
  double counts = 0, measures = 0;
  for (const CountPart& part : parts) {
    counts += part.count;
    measures += part.measure;
  }
  const double ratio = measures > 0 ? counts / measures : 0;
  if (parts.size() < 2 || !(measures > 0)) return {ratio, std::numeric_limits<double>::infinity()};
  double squares = 0;
  for (const CountPart& part : parts) {
    const double residual = part.count - ratio * part.measure;
    squares += residual * residual;
  }
  const auto m = static_cast<double>(parts.size());
  return {ratio, std::sqrt(m / (m - 1) * squares) / measures};
}

Measured combined(std::span<const Measured> values) {
  assert(!values.empty() && "there is something to combine");
  if (values.size() == 1) return values.front();
  constexpr double least = 1e-12;  // an exact value does not weigh infinitely
  double weights = 0, sum = 0;
  for (const Measured& v : values) {
    const double weight = 1 / std::max(least, v.uncertainty * v.uncertainty);
    weights += weight;
    sum += weight * v.value;
  }
  if (!(weights > 0)) return values.front();
  const double mean = sum / weights;
  double chi2 = 0;
  for (const Measured& v : values) chi2 += (v.value - mean) * (v.value - mean) / std::max(least, v.uncertainty * v.uncertainty);
  const double birge = std::max(1.0, chi2 / static_cast<double>(values.size() - 1));
  return {mean, std::sqrt(birge / weights)};
}

}  // namespace tactile
