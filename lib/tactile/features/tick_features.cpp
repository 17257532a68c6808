#include "tactile/features/tick_features.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/error.hpp"

namespace tactile::features {
namespace {

constexpr std::size_t fields = 3;  // across and down

double mean_or(std::uint64_t sum, std::uint64_t count, double unit, double otherwise) {
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) / unit : otherwise;
}

}  // namespace

void window_features(const EventSums& sums, events::SensorSize sensor, std::span<float, features_of_window> features) {
  const EventSums::OfPolarity &darker = sums.of[0], &brighter = sums.of[1];
  const double width = sensor.width, height = sensor.height;
  const std::uint64_t events = darker.events + brighter.events;
  const auto n = static_cast<double>(events);
  const double mean_x = mean_or(darker.x + brighter.x, events, width, 0.5);
  const double mean_y = mean_or(darker.y + brighter.y, events, height, 0.5);
  const double variance_x = mean_or(darker.xx + brighter.xx, events, width * width, 0.25) - mean_x * mean_x;
  const double variance_y = mean_or(darker.yy + brighter.yy, events, height * height, 0.25) - mean_y * mean_y;
  const double covariance = mean_or(darker.xy + brighter.xy, events, width * height, 0.25) - mean_x * mean_y;
  std::array<double, features_of_window> values{std::log1p(n),
                                                (static_cast<double>(brighter.events) + 0.5) / (n + 1),
                                                mean_x,
                                                mean_y,
                                                std::sqrt(std::clamp(variance_x, 0.0, 0.25)),
                                                std::sqrt(std::clamp(variance_y, 0.0, 0.25)),
                                                std::clamp(covariance, -0.25, 0.25)};
  if (darker.events > 0 && brighter.events > 0) {
    const auto difference = [&](std::uint64_t EventSums::OfPolarity::*sum, double unit) {
      return mean_or(brighter.*sum, brighter.events, unit, 0) - mean_or(darker.*sum, darker.events, unit, 0);
    };
    values[7] = difference(&EventSums::OfPolarity::x, width);
    values[8] = difference(&EventSums::OfPolarity::y, height);
    values[9] = difference(&EventSums::OfPolarity::xx, width * width) + difference(&EventSums::OfPolarity::yy, height * height);
  }
  double squares = 0, imbalance = 0;
  std::array<double, fields * fields> field{};
  for (std::size_t row = 0; row < grid_rows; ++row) {
    for (std::size_t column = 0; column < grid_columns; ++column) {
      const std::size_t cell = row * grid_columns + column;
      const double down = sums.cells[0][cell], up = sums.cells[1][cell];
      squares += (up + down) * (up + down);
      imbalance += (up - down) * (up - down);
      field[row / (grid_rows / fields) * fields + column / (grid_columns / fields)] += up + down;
    }
  }
  values[10] = squares > 0 ? n * n / squares / static_cast<double>(grid_cells) : 0;
  values[11] = events > 0 ? std::log1p(imbalance / n) : 0;
  for (std::size_t i = 0; i < field.size(); ++i)
    values[12 + i] = events > 0 ? field[i] / n : 1.0 / static_cast<double>(field.size());
  std::transform(values.begin(), values.end(), features.begin(), [](double value) { return static_cast<float>(value); });
}

std::optional<microseconds> feature_bin(microseconds tick, microseconds history) {
  if (tick <= microseconds{0} || history <= microseconds{0})
    throw Error(fmt::format("a history of {} us in ticks of {} us; expected more than 0 of each", history.count(), tick.count()));
  constexpr std::int64_t parts = windows_of_tick;
  if (history.count() % parts != 0) return std::nullopt;
  const microseconds bin{std::gcd(tick.count(), history.count() / parts)};
  if (history / bin > SlidingSums::most_bins) return std::nullopt;
  return bin;
}

microseconds bin_of(microseconds tick, microseconds history) {
  if (const auto bin = feature_bin(tick, history)) return *bin;
  throw Error(fmt::format("a history of {} us in ticks of {} us has no features; expected a multiple of 4 us, in at most {} bins",
                          history.count(), tick.count(), SlidingSums::most_bins));
}

TickFeatures tick_features(const SlidingSums& sums, events::SensorSize sensor) {
  TickFeatures features{};
  const std::size_t each = sums.bins() / windows_of_tick;
  for (std::size_t window = 0; window < windows_of_tick; ++window) {
    window_features(sums.sum(window * each, each), sensor,
                    std::span<float, features_of_window>(features.data() + window * features_of_window, features_of_window));
  }
  return features;
}

}  // namespace tactile::features
