#include "tactile/labels/onset.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactile {
namespace {

/// log-likelihood ratio of "rate rises as a u^p from bin `onset` on" against "it stays quiet", at the best a >= 0.
double rise_likelihood(std::span<const std::uint32_t> counts, std::size_t onset, double quiet, int power) {
  const auto shape = [&](std::size_t i) { return power == 0 ? 1.0 : static_cast<double>(i - onset) + 0.5; };
  double shape_sum = 0, count_sum = 0;
  for (std::size_t i = onset; i < counts.size(); ++i) {
    shape_sum += shape(i);
    count_sum += counts[i];
  }
  // The slope of the log-likelihood in a falls with a, so its zero is bracketed by 0 and what all counts together could need.
  const auto slope = [&](double a) {
    double sum = -shape_sum;
    for (std::size_t i = onset; i < counts.size(); ++i) sum += counts[i] * shape(i) / (quiet + a * shape(i));
    return sum;
  };
  if (slope(0.0) <= 0) return 0.0;
  double low = 0, high = count_sum / shape_sum;
  for (int step = 0; step < 40 && high - low > 1e-6 * high; ++step) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0 ? low : high) = middle;
  }
  const double a = 0.5 * (low + high);
  double likelihood = -a * shape_sum;
  for (std::size_t i = onset; i < counts.size(); ++i) likelihood += counts[i] * std::log1p(a * shape(i) / quiet);
  return likelihood;
}

/// How many bins hold enough to place the onset: up to where the events above the quiet rate stand out beyond doubt (Page's
/// cumulative sum). What a burst does later says nothing about its begin, but would bend the fit, for its counts are the largest.
std::size_t telling_bins(std::span<const std::uint32_t> counts, const QuietRate& quiet, std::size_t quiet_bins) {
  const double enough = std::max(60.0, 5.0 * std::sqrt(quiet.dispersion * quiet.mean * static_cast<double>(quiet_bins)));
  double excess = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    excess = std::max(0.0, excess + counts[i] - quiet.mean);
    if (excess >= enough) return i + 1;
  }
  return counts.size();
}

}  // namespace

UncertainTime onset_near(const EventRate& rate, const QuietRate& quiet, std::size_t candidate, const OnsetOptions& options) {
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t begin = candidate > bins(options.before) ? candidate - bins(options.before) : 0;
  const std::size_t end = std::min(rate.counts.size(), candidate + bins(options.after));
  std::span<const std::uint32_t> counts(rate.counts.data() + begin, end - begin);
  counts = counts.first(telling_bins(counts, quiet, bins(options.before)));
  // A pixel-perfect silence still has a rate; half an event in the whole stretch keeps the logarithm finite.
  const double quiet_per_bin = std::max(quiet.mean, 0.5 / static_cast<double>(counts.size()));

  std::vector<double> likelihood(counts.size());
  for (std::size_t onset = 0; onset < counts.size(); ++onset) {
    likelihood[onset] =
        std::max(rise_likelihood(counts, onset, quiet_per_bin, 0), rise_likelihood(counts, onset, quiet_per_bin, 1));
  }
  const auto best = static_cast<std::size_t>(std::max_element(likelihood.begin(), likelihood.end()) - likelihood.begin());
  const double limit = likelihood[best] - 1.92 * quiet.dispersion;
  std::size_t low = best, high = best;
  while (low > 0 && likelihood[low - 1] >= limit) --low;
  while (high + 1 < likelihood.size() && likelihood[high + 1] >= limit) ++high;
  // A bin stands for all of its span, and an onset inside it is seen from its end on.
  return {rate.begin_of(begin + best), before(rate.begin_of(begin + low), rate.bin + options.latency),
          rate.begin_of(begin + high + 1)};
}

}  // namespace tactile
