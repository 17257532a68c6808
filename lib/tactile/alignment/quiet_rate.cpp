#include "tactile/alignment/quiet_rate.hpp"

#include <algorithm>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {

QuietRate quiet_rate(const EventRate& rate) {
  const std::size_t width = static_cast<std::size_t>(std::max<std::int64_t>(1, 5ms / rate.bin));
  std::vector<double> sums;
  for (std::size_t begin = 0; begin + width <= rate.counts.size(); begin += width) {
    double sum = 0;
    for (std::size_t i = begin; i < begin + width; ++i) sum += rate.counts[i];
    sums.push_back(sum);
  }
  const double middle = median(sums);
  const double deviation = sigma_per_median * median(distances_from(middle, sums));
  return {.mean = middle / static_cast<double>(width),
          .dispersion = std::max(1.0, deviation * deviation / std::max(middle, 1.0))};
}

std::vector<CameraSpan> gaps_in(const EventRate& rate, const QuietRate& quiet, microseconds shortest) {
  constexpr double beyond_chance = 30.0;  // events missing: e^-30, and far less where noise comes in clumps of ten
  std::vector<CameraSpan> gaps;
  for (std::size_t begin = 0; begin < rate.counts.size();) {
    std::size_t end = begin;
    while (end < rate.counts.size() && rate.counts[end] == 0) ++end;
    const microseconds silent = rate.bin * static_cast<std::int64_t>(end - begin);
    if (silent >= shortest && quiet.mean * static_cast<double>(end - begin) >= beyond_chance * quiet.dispersion)
      gaps.push_back({rate.begin_of(begin), rate.begin_of(end)});
    begin = end + 1;
  }
  return gaps;
}

}  // namespace tactile::alignment
