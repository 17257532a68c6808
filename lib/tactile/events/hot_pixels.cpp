#include "tactile/events/hot_pixels.hpp"

#include <algorithm>
#include <iterator>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::events {

HotPixels find_hot_pixels(std::span<const std::uint32_t> counts, SensorSize size, double seconds, const HotPixelRule& rule) {
  constexpr double fewest_active_share = 0.01;
  HotPixels hot;
  std::vector<std::uint32_t> fired;
  std::copy_if(counts.begin(), counts.end(), std::back_inserter(fired), [](std::uint32_t count) { return count > 0; });
  hot.fired = fired.size();
  if (fired.empty() || seconds <= 0) return hot;

  const bool has_scene = static_cast<double>(fired.size()) >= fewest_active_share * static_cast<double>(counts.size());
  const double median = has_scene ? lower_median<std::uint32_t>(fired) : 1;
  hot.least_events = std::max({rule.over_median * median, rule.min_rate_hz * seconds, static_cast<double>(rule.min_events)});
  const auto count_at = [&](int x, int y) -> std::uint32_t {
    if (x < 0 || y < 0 || x >= size.width || y >= size.height) return 0;
    return counts[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const std::uint32_t count = count_at(x, y);
      if (count < hot.least_events) continue;
      std::uint32_t largest = 0, second = 0;  // of the 24 neighbours
      for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
          const std::uint32_t other = dx == 0 && dy == 0 ? 0 : count_at(x + dx, y + dy);
          second = std::max(second, std::min(largest, other));
          largest = std::max(largest, other);
        }
      }
      if (count >= rule.over_neighbours * second) hot.pixels.push_back({x, y, count, count / seconds});
    }
  }
  std::stable_sort(hot.pixels.begin(), hot.pixels.end(),
                   [](const HotPixel& a, const HotPixel& b) { return a.events > b.events; });
  return hot;
}

}  // namespace tactile::events
