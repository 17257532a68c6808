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
  double variance = 0;            ///< of all differences together, by chance
  double variance_of_square = 0;  ///< by chance

  void add(std::span<const PlaceCounts::Sign> signs, double weight) {
    for (const PlaceCounts::Sign& one : signs) difference[one.cell] += weight * one.sign, events[one.cell] += weight;
    variance += std::pow(weight, 2) * static_cast<double>(signs.size());
    variance_of_square += 2 * std::pow(weight, 4) * static_cast<double>(signs.size());
  }

  /// Square of its length, less what chance gives.
  double square() const { return std::inner_product(difference.begin(), difference.end(), difference.begin(), 0.0) - variance; }
  bool is_clear(double square) const { return variance > 0 && square >= clear * std::sqrt(variance_of_square); }
};

double log_normal(double x, double mean, double variance) {
  return -0.5 * (x - mean) * (x - mean) / variance - 0.5 * std::log(variance);
}

}  // namespace

std::vector<double> pattern_evidence(const PlaceCounts& counts, std::span<const PressBins> presses,
                                     std::span<const double> moves) {
  std::vector<double> evidence(counts.bins() * happenings, 0.0);
  const auto block = static_cast<std::size_t>(std::max<std::int64_t>(1, 50ms / counts.bin));
  std::vector<const PressBins*> left_out;  // of the pattern of the presses
  Pattern press;
  double press_square = 0, surest = 0;
  for (std::size_t begin = 0; begin < counts.bins(); begin += block) {
    const std::size_t end = std::min(counts.bins(), begin + block);
    const double moving = std::accumulate(moves.begin() + static_cast<std::ptrdiff_t>(begin),
                                          moves.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    if (moving < 0.2 * static_cast<double>(end - begin)) continue;
    Pattern here;
    here.add(counts.signs_in(begin, end), 1);
    const double square = here.square();
    if (!here.is_clear(square)) continue;
    std::vector<const PressBins*> around;
    for (const PressBins& one : presses) {
      if (begin < one.end && end > one.begin) around.push_back(&one);
    }
    if (press.variance == 0 || around != left_out) {
      left_out = around;
      press = {};
      surest = 0;
      for (const PressBins& one : presses) {
        if (std::find(around.begin(), around.end(), &one) != around.end()) continue;
        press.add(counts.signs_in(one.begin, one.end), one.weight);
        surest = std::max(surest, one.probability);
      }
      press_square = press.square();
    }
    if (!press.is_clear(press_square)) continue;
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
      of[static_cast<std::size_t>(Happening::press)] = surest * counted * moves[bin] / moving * relative(0.5);
      of[static_cast<std::size_t>(Happening::release)] = surest * counted * moves[bin] / moving * relative(-0.5);
    }
  }
  return evidence;
}

}  // namespace tactile::labels
