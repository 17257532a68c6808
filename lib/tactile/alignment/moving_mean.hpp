#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tactile::alignment {

/// Means over `width` values centred on each; at the ends over as many as there are.
template <class T>
std::vector<double> moving_mean(const std::vector<T>& values, std::size_t width) {
  const std::size_t n = values.size();
  std::vector<double> until(n + 1), means(n);
  for (std::size_t i = 0; i < n; ++i) until[i + 1] = until[i] + static_cast<double>(values[i]);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t begin = i - std::min(i, width / 2), end = std::min(n, i + width - width / 2);
    means[i] = (until[end] - until[begin]) / static_cast<double>(end - begin);
  }
  return means;
}

}  // namespace tactile::alignment
