#include "tactile/characterise/noise_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tactile::characterise {
namespace {

constexpr int highest_shape = 12;

/// Moments for one pixel, not yet divided by means.
struct PixelMoments {
  double squared_difference = 0, product = 0;
  double silent = 0;  ///< chance of no event in one window
};

/// Every k-th event of a Poisson process, starting anywhere between two that count.
PixelMoments pixel_moments(int k, double mean) {
  const double events = k * mean;
  const auto most = static_cast<std::size_t>(events + 10 * std::sqrt(events) + 10);
  std::vector<double> chance(most + 1);
  chance[0] = std::exp(-events);
  if (chance[0] < 1e-300) {  // far from 0: begin in the middle
    const auto middle = static_cast<std::size_t>(events);
    chance[middle] =
        std::exp(-events + static_cast<double>(middle) * std::log(events) - std::lgamma(static_cast<double>(middle) + 1));
    for (std::size_t m = middle; m > 0; --m) chance[m - 1] = chance[m] * static_cast<double>(m) / events;
    for (std::size_t m = middle; m < most; ++m) chance[m + 1] = chance[m] * events / static_cast<double>(m + 1);
  } else {
    for (std::size_t m = 0; m < most; ++m) chance[m + 1] = chance[m] * events / static_cast<double>(m + 1);
  }
  const auto phases = static_cast<std::size_t>(k);
  std::vector<double> expected(phases);  // of the next window, after a phase
  double squares = 0, product = 0, silent = 0;
  for (std::size_t phase = 0; phase < phases; ++phase) {
    for (std::size_t m = 0; m <= most; ++m) {
      const std::size_t counted = (m + phase) / phases;
      const auto n = static_cast<double>(counted);
      expected[phase] += chance[m] * n;
      squares += chance[m] * n * n;
      if (m + phase < phases) silent += chance[m];
    }
  }
  for (std::size_t phase = 0; phase < phases; ++phase) {
    for (std::size_t m = 0; m <= most; ++m) {
      const std::size_t counted = (m + phase) / phases;
      product += chance[m] * static_cast<double>(counted) * expected[(m + phase) % phases];
    }
  }
  return {2 * (squares - product) / k, product / k, silent / k};
}

/// Calls `use(weight, factor)` for rates of pixels that are `factor` times their mean. @return  the sum of the weights
template <class Use>
double for_rates(double spread, const Use& use) {
  constexpr int nodes = 33;
  constexpr double reach = 4.0;
  double weights = 0;
  for (int i = 0; i < nodes; ++i) {
    const double z = reach * (2.0 * i / (nodes - 1) - 1);
    const double weight = std::exp(-z * z / 2);
    weights += weight;
    use(weight, std::exp(spread * z - spread * spread / 2));
    if (spread == 0) break;
  }
  return weights;
}

constexpr double most_events = 2000;  // of a pixel: more have the same moments

WindowMoments whole_shape_moments(int k, double spread, double mean) {
  WindowMoments moments;
  const double weights = for_rates(spread, [&](double weight, double factor) {
    const PixelMoments pixel = pixel_moments(k, std::min(most_events, mean * factor));
    moments.differences += weight * pixel.squared_difference;
    moments.products += weight * pixel.product;
  });
  moments.differences /= weights * 2 * mean;
  moments.products = moments.products / weights / (mean * mean) - 1;
  return moments;
}

double whole_shape_silent(int k, double spread, std::span<const double> means) {
  double silent = 0;
  const double weights = for_rates(spread, [&](double weight, double factor) {
    double chance = weight;
    for (const double mean : means) {
      if (chance < 1e-12) break;
      chance *= pixel_moments(k, std::min(most_events, mean * factor)).silent;
    }
    silent += chance;
  });
  return silent / weights;
}

/// How far a shape lies from `below` to the next whole one.
double share_above(int below, double shape) {
  return std::clamp((1.0 / below - 1 / shape) / (1.0 / below - 1.0 / (below + 1)), 0.0, 1.0);
}

/// The spread with these products, for a whole shape.
double spread_of(int k, double products, double mean) {
  double low = 0, high = 2.5;
  if (whole_shape_moments(k, low, mean).products >= products) return low;
  for (int step = 0; step < 24; ++step) {
    const double middle = (low + high) / 2;
    (whole_shape_moments(k, middle, mean).products < products ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

WindowSums& WindowSums::operator+=(const WindowSums& other) {
  pairs += other.pairs;
  sum += other.sum;
  squared_differences += other.squared_differences;
  products += other.products;
  return *this;
}

WindowMoments moments_of(const NoiseModel& model, double mean) {
  if (model.shape <= 1) {  // bursts: only the differences grow
    WindowMoments moments = whole_shape_moments(1, model.spread, mean);
    moments.differences /= model.shape;
    return moments;
  }
  const int below = std::min(highest_shape - 1, static_cast<int>(model.shape));
  const WindowMoments a = whole_shape_moments(below, model.spread, mean);
  const WindowMoments b = whole_shape_moments(below + 1, model.spread, mean);
  const double share = share_above(below, model.shape);
  return {a.differences + share * (b.differences - a.differences), a.products + share * (b.products - a.products)};
}

double silent_share(const NoiseModel& model, std::span<const double> means) {
  if (model.shape <= 1) return whole_shape_silent(1, model.spread, means);
  const int below = std::min(highest_shape - 1, static_cast<int>(model.shape));
  const double a = whole_shape_silent(below, model.spread, means), b = whole_shape_silent(below + 1, model.spread, means);
  return a + share_above(below, model.shape) * (b - a);
}

NoiseModel noise_model(const WindowSums& sums) {
  if (!(sums.sum > 0)) return {};
  const double mean = sums.sum / sums.pairs / 2;
  const double differences = sums.squared_differences / sums.sum;
  const double products = sums.products / sums.pairs / (mean * mean) - 1;
  NoiseModel last{.shape = 1, .spread = spread_of(1, products, mean)};
  double last_differences = whole_shape_moments(1, last.spread, mean).differences;
  if (differences >= last_differences) return {last_differences / differences, last.spread};
  for (int k = 2; k <= highest_shape; ++k) {
    const NoiseModel next{.shape = static_cast<double>(k), .spread = spread_of(k, products, mean)};
    const double next_differences = whole_shape_moments(k, next.spread, mean).differences;
    if (differences >= next_differences) {
      const double share = (last_differences - differences) / (last_differences - next_differences);
      return {1 / (1 / last.shape + share * (1 / next.shape - 1 / last.shape)),
              last.spread + share * (next.spread - last.spread)};
    }
    last = next;
    last_differences = next_differences;
  }
  return last;
}

}  // namespace tactile::characterise
