#include "tactile/labels/onset_scan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "tactile/core/infinite.hpp"

namespace tactile::labels {
namespace {

/// The best b, c >= 0 of rate = base + b + c x, with x in bins from the stretch's start, and its log-likelihood.
struct Rise {
  double b = 0, c = 0;
  double log_likelihood = -infinite;
};

/// Newton's method on a concave function, kept inside b, c >= 0. A parameter that is not fitted stays 0.
/// @param filled  of the bins [from, to)
Rise fit_rise(std::span<const Filled> filled, std::size_t from, std::size_t to, double base, bool with_b, bool with_c) {
  const auto n = static_cast<double>(to - from);
  const double first = static_cast<double>(from) - 0.5, x_sum = 0.5 * n * n;
  double events = 0;
  for (const Filled& bin : filled) events += bin.count;
  // Start from the best flat or even rise.
  Rise rise{.b = with_b ? std::max(1e-3, (events / n - base) * (with_c ? 0.5 : 1.0)) : 0.0,
            .c = with_c ? std::max(1e-3 / n, (events - base * n) / x_sum * (with_b ? 0.5 : 1.0)) : 0.0};
  for (int step = 0; step < 30; ++step) {
    double gb = -n, gc = -x_sum, hbb = 1e-12, hbc = 0, hcc = 1e-12;
    for (const Filled& bin : filled) {
      const double x = bin.at - first;
      const double w = 1.0 / (base + rise.b + rise.c * x), cw = bin.count * w;
      gb += cw;
      gc += cw * x;
      hbb += cw * w;
      hbc += cw * w * x;
      hcc += cw * w * x * x;
    }
    const double determinant = hbb * hcc - hbc * hbc;
    const bool both = with_b && with_c && determinant > 1e-9 * hbb * hcc;
    const double db = both ? (hcc * gb - hbc * gc) / determinant : with_b ? gb / hbb : 0.0;
    const double dc = both ? (hbb * gc - hbc * gb) / determinant : with_c && !with_b ? gc / hcc : 0.0;
    const double b = std::max(with_b ? 0.1 * rise.b : 0.0, rise.b + db), c = std::max(with_c ? 0.1 * rise.c : 0.0, rise.c + dc);
    const double change = std::abs(b - rise.b) + n * std::abs(c - rise.c);
    rise.b = b;
    rise.c = c;
    if (change < 1e-4 * (base + b + n * c)) break;
  }
  rise.log_likelihood = -(base + rise.b) * n - rise.c * x_sum;
  for (const Filled& bin : filled) rise.log_likelihood += bin.count * std::log(base + rise.b + rise.c * (bin.at - first));
  return rise;
}

/// For how long a marker may have moved before its first events. A pixel that has to undo its last change is blind at first: for
/// as long as the first ones that fire take from one event to the next.
microseconds blind_time_before(microseconds bin, Counts counts, Counts repeats, std::size_t onset, microseconds longest) {
  if (repeats.size() != counts.size()) return 0us;  // they were not counted
  constexpr double enough = 3.0;                    // not one pixel alone, which might be noise
  const auto most = static_cast<std::size_t>(longest / bin);
  // So many events repeat one of their pixel's noise by chance.
  const auto sum = [onset](Counts of) {
    return std::accumulate(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(std::min(onset, of.size())), 0.0);
  };
  const double by_chance = sum(repeats) / std::max(1.0, sum(counts));
  double so_far = 0, expected = 0;
  std::size_t i = onset;
  for (; i < repeats.size() && i < onset + most && so_far < expected + enough + 2.0 * std::sqrt(expected); ++i) {
    so_far += repeats[i];
    expected += by_chance * counts[i];
  }
  return bin * static_cast<std::int64_t>(i - onset);
}

}  // namespace

std::vector<Filled> filled_bins(Counts counts) {
  std::vector<Filled> filled;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) filled.push_back({static_cast<double>(i), static_cast<double>(counts[i])});
  }
  return filled;
}

std::span<const Filled> filled_from(const std::vector<Filled>& filled, std::size_t from) {
  const auto first = std::partition_point(filled.begin(), filled.end(),
                                          [from](const Filled& bin) { return bin.at < static_cast<double>(from); });
  return {first, filled.end()};
}

double best_rise(std::span<const Filled> filled, std::size_t from, std::size_t to, double base) {
  double best = -infinite;
  for (const auto& [with_b, with_c] : {std::pair{true, false}, {false, true}, {true, true}})
    best = std::max(best, fit_rise(filled, from, to, base, with_b, with_c).log_likelihood);
  return best;
}

std::vector<double> rise_likelihoods(Counts counts, double quiet) {
  const Sums sums(counts);
  const std::vector<Filled> filled = filled_bins(counts);
  std::vector<double> likelihoods(counts.size());
  for (std::size_t tau = 0; tau < counts.size(); ++tau) {
    likelihoods[tau] = log_likelihood_of(sums.of(0, tau), static_cast<double>(tau), quiet) +
                       best_rise(filled_from(filled, tau), tau, counts.size(), quiet);
  }
  return likelihoods;
}

Scan scan_of(const std::vector<double>& likelihood, double dispersion) {
  Scan scan;
  scan.best = static_cast<std::size_t>(std::max_element(likelihood.begin(), likelihood.end()) - likelihood.begin());
  const double limit = likelihood[scan.best] - half_chi2 * dispersion;
  scan.low = scan.high = scan.best;
  for (std::size_t i = 0; i < likelihood.size(); ++i) {
    if (likelihood[i] < limit) continue;
    scan.low = std::min(scan.low, i);
    scan.high = std::max(scan.high, i);
  }
  return scan;
}

FoundTime found_at(const LitRate& lit, const Scan& scan, Counts counts, Counts repeats, double blind_share,
                   const OnsetOptions& options) {
  const alignment::EventRate& rate = lit.rate;
  const auto more = static_cast<double>((options.blind_reset - options.longest_blind).count());
  const microseconds longest = options.longest_blind + microseconds{std::llround(lit.reset_share * more)};
  const auto blind_us = static_cast<double>(blind_time_before(rate.bin, counts, repeats, scan.best, longest).count());
  const microseconds blind = std::max(options.latency, microseconds{std::llround(blind_share * blind_us)});
  FoundTime result{.time = {.at = before(rate.begin_of(scan.best), rate.bin / 2),
                            .low = before(rate.begin_of(scan.low), rate.bin + blind),
                            .high = after(rate.begin_of(scan.high), rate.bin / 2 + options.noise_ahead)},
                   .doubt = {}};
  const double width_ms = 1e-3 * static_cast<double>(between(result.time.low, result.time.high).count());
  if (width_ms > options.too_wide_ms)
    result.doubt = doubt("onset-width", "its onset is only known to within {:.0f} ms", width_ms);
  return result;
}

}  // namespace tactile::labels
