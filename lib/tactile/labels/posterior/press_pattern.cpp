#include "tactile/labels/posterior/press_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactile::labels {
namespace {

constexpr double counted = 0.4, clear = 4, most_evidence = 6;

/// Brighter less darker events of each cell, and all of them.
struct Pattern {
  std::vector<double> difference = std::vector<double>(PlaceCounts::cells, 0.0);
  std::vector<double> events = std::vector<double>(PlaceCounts::cells, 0.0);
  double count = 0;

  explicit Pattern(std::span<const PlaceCounts::Sign> signs) : count(static_cast<double>(signs.size())) {
    for (const PlaceCounts::Sign& one : signs) difference[one.cell] += one.sign, events[one.cell] += 1;
  }

  /// Square of its length, less what chance gives.
  double square() const { return std::inner_product(difference.begin(), difference.end(), difference.begin(), 0.0) - count; }
};

double log_normal(double x, double mean, double variance) {
  return -0.5 * (x - mean) * (x - mean) / variance - 0.5 * std::log(variance);
}

}  // namespace

std::vector<double> pattern_evidence(const PlaceCounts& counts, std::size_t press_begin, std::size_t press_end,
                                     std::span<const double> moves) {
  std::vector<double> evidence(counts.bins() * happenings, 0.0);
  const Pattern press(counts.signs_in(press_begin, press_end));
  const double press_square = press.square();
  if (press_square < clear * std::sqrt(2 * press.count)) return evidence;
  const auto block = static_cast<std::size_t>(std::max<std::int64_t>(1, 50ms / counts.bin));
  for (std::size_t begin = 0; begin < counts.bins(); begin += block) {
    const std::size_t end = std::min(counts.bins(), begin + block);
    if (begin < press_end && end > press_begin) continue;
    const double moving = std::accumulate(moves.begin() + static_cast<std::ptrdiff_t>(begin),
                                          moves.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    if (moving < 0.2 * static_cast<double>(end - begin)) continue;
    const Pattern here(counts.signs_in(begin, end));
    const double square = here.square();
    if (square < clear * std::sqrt(2 * here.count)) continue;
    double product = 0, noise = 0;
    for (std::size_t cell = 0; cell < PlaceCounts::cells; ++cell) {
      product += here.difference[cell] * press.difference[cell];
      noise += here.events[cell] * press.difference[cell] * press.difference[cell];
    }
    const double cosine = product / std::sqrt(square * press_square), variance = noise / (square * press_square);
    const double other = log_normal(cosine, 0, 0.0225 + variance);
    const auto relative = [&](double mean) {
      return std::clamp(log_normal(cosine, mean, 0.0625 + variance) - other, -most_evidence, most_evidence);
    };
    for (std::size_t bin = begin; bin < end; ++bin) {
      double* of = &evidence[bin * happenings];
      of[static_cast<std::size_t>(Happening::press)] = counted * moves[bin] / moving * relative(0.5);
      of[static_cast<std::size_t>(Happening::release)] = counted * moves[bin] / moving * relative(-0.5);
    }
  }
  return evidence;
}

}  // namespace tactile::labels
