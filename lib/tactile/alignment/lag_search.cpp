#include "tactile/alignment/lag_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tactile::alignment {

double energy_of(std::span<const double> values) { return std::inner_product(values.begin(), values.end(), values.begin(), 0.0); }

void keep_strongest(std::span<std::vector<double>* const> axes, std::size_t length) {
  const std::size_t n = axes.front()->size();
  if (n <= length) return;
  const auto power = [&](std::size_t i) {
    double sum = 0;
    for (const std::vector<double>* axis : axes) sum += (*axis)[i] * (*axis)[i];
    return sum;
  };
  double sum = 0, best = -1;
  std::size_t best_end = 0;
  for (std::size_t i = 0; i < n; ++i) {
    sum += power(i);
    if (i >= length) sum -= power(i - length);
    if (i + 1 >= length && sum > best) {
      best = sum;
      best_end = i + 1;
    }
  }
  for (std::vector<double>* axis : axes) {
    const auto end = axis->begin() + static_cast<std::ptrdiff_t>(best_end);
    std::fill(axis->begin(), end - static_cast<std::ptrdiff_t>(length), 0.0);
    std::fill(end, axis->end(), 0.0);
  }
}

void keep_within(std::vector<double>& scores, const Lags& lags, const AnchorSearch& search) {
  const std::optional<CoarseOffset>& coarse = search.inputs.coarse;
  if (!coarse) return;
  const double middle_s = 1e-6 * static_cast<double>(saturating_subtract(coarse->offset_us, search.origins.apart_us));
  const double within_s = 1e-6 * static_cast<double>(coarse->within.count());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (std::abs(lags.shift_of(static_cast<double>(i)) - middle_s) > within_s) scores[i] = 0;
  }
}

double Peak::ratio() const { return second > 0 ? value / second : std::numeric_limits<double>::infinity(); }

std::optional<Peak> highest_peak(std::span<const double> scores) {
  if (scores.empty()) return std::nullopt;
  Peak peak;
  peak.index = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  peak.value = scores[peak.index];
  if (!(peak.value > 0)) return std::nullopt;
  std::size_t low = peak.index, high = peak.index;
  while (low > 0 && scores[low - 1] <= scores[low]) --low;
  while (high + 1 < scores.size() && scores[high + 1] <= scores[high]) ++high;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (i < low || i > high) peak.second = std::max(peak.second, scores[i]);
  }
  if (peak.index > 0 && peak.index + 1 < scores.size()) {
    const double a = scores[peak.index - 1], b = scores[peak.index], c = scores[peak.index + 1];
    const double curvature = a - 2 * b + c;
    if (curvature < 0) peak.offset = std::clamp(0.5 * (a - c) / curvature, -0.5, 0.5);
  }
  return peak;
}

std::vector<std::size_t> peaks_near_best(std::vector<double> scores, double share, std::size_t apart) {
  constexpr std::size_t most = 100;
  std::vector<std::size_t> peaks;
  double least = 0;
  while (!scores.empty() && peaks.size() < most) {
    const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
    if (peaks.empty()) least = share * scores[best];
    if (!(scores[best] > 0) || scores[best] < least) break;
    peaks.push_back(best);
    const std::size_t from = best - std::min(best, apart), to = std::min(scores.size(), best + apart + 1);
    std::fill(scores.begin() + static_cast<std::ptrdiff_t>(from), scores.begin() + static_cast<std::ptrdiff_t>(to), 0.0);
  }
  return peaks;
}

KnownShifts::Nearest KnownShifts::nearest(double at_s) const {
  Nearest nearest{first_s, std::abs(at_s - first_at_s)};
  for (const auto& [known_at_s, shift_s] : found) {
    if (std::abs(at_s - known_at_s) <= nearest.distance_s) nearest = {shift_s, std::abs(at_s - known_at_s)};
  }
  return nearest;
}

}  // namespace tactile::alignment
