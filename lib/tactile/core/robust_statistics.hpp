#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

namespace tactile {

// Statistics that a few outliers do not change. None changes its argument; each gives 0 where there are no values. Values that
// are not doubles name their type: median<float>(residuals).

/// The median of |x| of normal noise around 0, times this, is the standard deviation: 1 / the quantile of the normal at 3/4.
inline constexpr double sigma_per_median = 1.4826;

/// The value at place `rank` of the sorted values. @param rank  from 0, below their number
template <class T = double, class Less = std::less<T>>
T value_of_rank(std::span<const std::type_identity_t<T>> values, std::size_t rank, Less less = {}) {
  if (values.empty()) return T{};
  std::vector<T> copy(values.begin(), values.end());
  const auto place = copy.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(copy.begin(), place, copy.end(), less);
  return *place;
}

/// The middle value; of two in the middle their mean, for whole numbers rounded towards the lower.
template <class T = double>
T median(std::span<const std::type_identity_t<T>> values) {
  if (values.empty()) return T{};
  std::vector<T> copy(values.begin(), values.end());
  const auto upper = copy.begin() + static_cast<std::ptrdiff_t>(copy.size() / 2);
  std::nth_element(copy.begin(), upper, copy.end());
  if (copy.size() % 2 == 1) return *upper;
  const T lower = *std::max_element(copy.begin(), upper);
  return static_cast<T>(lower + (*upper - lower) / 2);
}

/// The middle value; of two in the middle the lower: always one of the values.
template <class T = double>
T lower_median(std::span<const std::type_identity_t<T>> values) {
  return value_of_rank<T>(values, values.empty() ? 0 : (values.size() - 1) / 2);
}

/// |x - centre| of each. Their median around the values' own median is the median absolute deviation.
std::vector<double> distances_from(double centre, std::span<const double> values);

/// The value below which the share `q` of them lies, on straight lines between the sorted values x_0 ... x_(n-1):
///
///   x_k + (h - k) (x_(k+1) - x_k),   h = q (n - 1),   k = floor(h)
///
/// @param q  in [0, 1]
/// Source: R. J. Hyndman and Y. Fan, Sample quantiles in statistical packages, The American Statistician 50 (1996), definition 7.
double quantile(std::span<const double> values, double q);

/// The least of the values that the share `q` of them does not exceed: x_(ceil(q n) - 1), definition 1 of the same source.
double nearest_rank_quantile(std::span<const double> values, double q);

}  // namespace tactile
