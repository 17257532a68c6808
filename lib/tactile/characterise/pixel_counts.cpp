#include "tactile/characterise/pixel_counts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/events/hot_pixels.hpp"

namespace tactile::characterise {
namespace {

using Kind = UnusualPixel::Kind;

UnusualPixel pixel_at(const PixelCounts& counts, std::size_t pixel, Kind kind) {
  const auto width = static_cast<std::size_t>(counts.size.width);
  const double n = counts.events(pixel);
  return {.kind = kind,
          .x = static_cast<int>(pixel % width),
          .y = static_cast<int>(pixel / width),
          .rate_hz = {n / counts.seconds, std::sqrt(n) / counts.seconds},
          .on_share = counts.on[pixel] / n};
}

/// Pixels that would be on the other side of a limit if they had one standard deviation more or less.
double near_limit(const PixelCounts& counts, double limit) {
  double near = 0;
  for (std::size_t i = 0; i < counts.pixels(); ++i) near += std::abs(counts.events(i) - limit) < std::sqrt(limit);
  return near;
}

Measured counted(std::size_t n, double near) { return {static_cast<double>(n), std::sqrt(static_cast<double>(n) + near)}; }

}  // namespace

UnusualPixels unusual_pixels(const PixelCounts& counts, const std::vector<bool>& lit) {
  constexpr double over_mean = 10, fewest_events = 10, stuck_share = 0.5;
  UnusualPixels unusual;
  std::vector<std::uint32_t> sums(counts.pixels());
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = counts.on[i] + counts.off[i];
  const events::HotPixels hot = events::find_hot_pixels(sums, counts.size, counts.seconds);
  const double stuck_events =
      counts.period_us > 0 ? stuck_share * counts.seconds * 1e6 / counts.period_us : std::numeric_limits<double>::infinity();
  std::unordered_set<std::size_t> found;
  double all = 0, of_loud = 0;
  for (const std::uint32_t n : sums) all += n;
  for (const events::HotPixel& pixel : hot.pixels) {
    const auto at =
        static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(counts.size.width) + static_cast<std::size_t>(pixel.x);
    found.insert(at);
    unusual.pixels.push_back(pixel_at(counts, at, pixel.events >= stuck_events ? Kind::stuck : Kind::hot));
    of_loud += pixel.events;
  }
  const double mean = (all - of_loud) / static_cast<double>(std::max<std::size_t>(1, counts.pixels() - found.size()));
  const double least = std::max(over_mean * mean, fewest_events);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i] >= least && !found.contains(i)) unusual.pixels.push_back(pixel_at(counts, i, Kind::warm));
  }
  std::stable_sort(unusual.pixels.begin(), unusual.pixels.end(),
                   [](const UnusualPixel& a, const UnusualPixel& b) { return a.rate_hz.value > b.rate_hz.value; });
  std::array<std::size_t, 4> numbers{};
  std::vector<double> on_shares;
  double of_hot = 0, squares = 0;
  for (UnusualPixel& pixel : unusual.pixels) {
    const std::size_t at = counts.index_of(pixel);
    if (!lit.empty() && lit[at]) pixel.kind = Kind::lit;
    ++numbers[static_cast<std::size_t>(pixel.kind)];
    if (pixel.kind == Kind::warm || pixel.kind == Kind::hot) on_shares.push_back(pixel.on_share);
    if (!pixel.is_hot()) continue;
    of_hot += sums[at];
    squares += static_cast<double>(sums[at]) * sums[at];
  }
  unusual.warm = counted(numbers[static_cast<std::size_t>(Kind::warm)], near_limit(counts, least));
  unusual.hot = counted(numbers[static_cast<std::size_t>(Kind::hot)], near_limit(counts, hot.least_events));
  unusual.stuck = counted(numbers[static_cast<std::size_t>(Kind::stuck)], 0);
  unusual.lit = numbers[static_cast<std::size_t>(Kind::lit)];
  unusual.hot_share = {of_hot / std::max(1.0, all), std::sqrt(squares) / std::max(1.0, all)};
  if (!on_shares.empty()) unusual.on_share = mean_of(on_shares);
  return unusual;
}

std::vector<bool> ordinary_pixels(const PixelCounts& counts, const UnusualPixels& unusual) {
  std::vector<bool> ordinary(counts.pixels(), true);
  for (const UnusualPixel& pixel : unusual.pixels)
    ordinary[static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(counts.size.width) +
             static_cast<std::size_t>(pixel.x)] = false;
  return ordinary;
}

Measured on_spread(const PixelCounts& counts, const std::vector<bool>& ordinary) {
  constexpr std::size_t groups = 16;
  double on = 0, all = 0;
  for (std::size_t i = 0; i < counts.pixels(); ++i) {
    if (!ordinary[i]) continue;
    on += counts.on[i];
    all += counts.events(i);
  }
  const double share = all > 0 ? on / all : 0.5;
  std::array<CountPart, groups> parts{};
  for (std::size_t i = 0; i < counts.pixels(); ++i) {
    const double n = counts.events(i);
    if (!ordinary[i] || n < 2) continue;
    const double residual = counts.on[i] - n * share;
    CountPart& part = parts[i % groups];
    part.count += residual * residual - n * share * (1 - share);
    part.measure += n * (n - 1);
  }
  const Measured variance = ratio_of(parts);
  const double spread = std::sqrt(std::max(0.0, variance.value));
  const bool is_seen = variance.value > variance.uncertainty;
  return {spread, is_seen ? variance.uncertainty / (2 * spread) : std::sqrt(variance.uncertainty)};
}

std::vector<double> rate_quantiles(const PixelCounts& counts, const std::vector<bool>& ordinary) {
  constexpr int steps = 100;
  std::vector<double> rates;
  for (std::size_t i = 0; i < counts.pixels(); ++i) {
    if (ordinary[i]) rates.push_back(counts.events(i) / counts.seconds);
  }
  std::sort(rates.begin(), rates.end());
  std::vector<double> quantiles;
  for (int i = 0; i <= steps && !rates.empty(); ++i)
    quantiles.push_back(rates[(rates.size() - 1) * static_cast<std::size_t>(i) / steps]);
  return quantiles;
}

}  // namespace tactile::characterise
