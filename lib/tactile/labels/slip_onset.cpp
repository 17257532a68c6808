#include <algorithm>
#include <cmath>

#include "tactile/core/infinite.hpp"
#include "tactile/labels/onset_scan.hpp"

namespace tactile::labels {
namespace {

/// A drag begins at a speed. A gradual rise that a sharper jump follows soon is a partial slip, or ringing as strong as a drag.
/// @return that jump, if there is one
std::optional<std::size_t> sharper_jump(const LitRate& lit, std::size_t onset, std::size_t width, std::size_t within) {
  const Sums sums(lit.rate.counts);
  const std::size_t n = lit.rate.counts.size(), gap = width / 5;
  if (onset < width + gap || onset + 5 * width > n) return std::nullopt;
  const auto rise_at = [&](std::size_t at) {  // of the root of the rate: its noise is the same for all rates
    if (at < width + gap || at + width + gap > n) return 0.0;
    return std::sqrt(sums.of(at + gap, at + gap + width)) - std::sqrt(sums.of(at - width - gap, at - gap));
  };
  const double step = sums.of(onset + 2 * gap, onset + 2 * gap + width) - sums.of(onset - width - gap, onset - gap);
  const double reached = 0.5 * sums.of(onset + 3 * width, onset + 5 * width);
  if (step >= 0.5 * reached) return std::nullopt;
  const double here = std::max(rise_at(onset), rise_at(onset + width / 2));
  std::size_t best = onset;
  double most = 0;
  for (std::size_t i = onset + width + width / 2; i < std::min(n, onset + within); ++i) {
    if (rise_at(i) <= most) continue;
    most = rise_at(i);
    best = i;
  }
  return most > 1.3 * here && most > 2.0 ? std::optional(best) : std::nullopt;
}

/// The first bin in which a slip may begin. A few tips that spring back before the lift are a stretch of their own: a long quiet
/// follows it, and it is small against what comes then.
std::size_t slip_begin(const LitRate& lit) {
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(std::max<std::int64_t>(1, span / lit.rate.bin)); };
  const std::size_t width = bins(5ms), apart = bins(40ms);
  const Sums sums(lit.rate.counts);
  const double noise = lit.quiet_per_bin * static_cast<double>(width);
  const double limit = noise + 4.0 * std::sqrt(lit.dispersion * noise) + 4.0;
  struct Piece {
    std::size_t begin, end;
  };
  std::vector<Piece> pieces;
  for (std::size_t i = lit.burst_begin; i + width <= lit.burst_end; ++i) {
    if (sums.of(i, i + width) < limit) continue;
    if (pieces.empty() || i > pieces.back().end + apart) pieces.push_back({i, i + width});
    pieces.back().end = i + width;
  }
  for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
    const double here = sums.of(pieces[i].begin, pieces[i].end);
    const double later = sums.of(pieces[i + 1].begin, pieces.back().end) / static_cast<double>(pieces.size() - i - 1);
    if (here >= 0.08 * later) return pieces[i].begin;
  }
  return pieces.empty() ? lit.burst_begin : pieces.back().begin;
}

/// Where a slip's onset is searched: bins [begin, end) of its burst's rate.
struct SlipRange {
  std::size_t begin = 0, end = 0;
  double dragged = 0;  ///< events per bin: the rate of a drag
};

/// Up to where the rate first has 0.3 of what the first drag reaches: the drag has begun by then. That drag is searched from
/// where the rate exceeds ringing. Later jerks do not matter.
SlipRange slip_range(const LitRate& lit, std::size_t width, const OnsetOptions& options,
                     const std::optional<alignment::UncertainTime>& lift_start) {
  const alignment::EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t first = slip_begin(lit);
  std::size_t begin = first - std::min(first, bins(options.before));
  if (lift_start && lift_start->low > rate.begin_of(begin))
    begin = std::min(static_cast<std::size_t>(between(rate.begin, lift_start->low) / rate.bin), first);
  const Sums all(rate.counts);
  const std::size_t rise_end = std::min(rate.counts.size(), first + bins(options.rise));
  const double noise = lit.quiet_per_bin * static_cast<double>(width);
  const double stands_out = 5.0 * std::sqrt(lit.dispersion * std::max(noise, 0.5));
  const auto most_in = [&](std::size_t from, std::size_t to) {  // above the noise
    double most = 0;
    for (std::size_t i = from; i + width <= to; ++i) most = std::max(most, all.of(i, i + width) - noise);
    return most;
  };
  const auto first_above = [&](std::size_t from, double limit) {
    std::size_t i = from;
    while (i + width < rise_end && all.of(i, i + width) - noise < std::max(limit, stands_out)) ++i;
    return i;
  };
  const std::size_t strong = first_above(begin, 0.08 * most_in(first, rise_end));
  const double most = most_in(strong, std::min(rise_end, strong + bins(options.first_drag)));
  const std::size_t end = std::min(rise_end, first_above(strong, 0.3 * most) + 2 * width);
  const std::size_t longest = bins(options.before) + bins(options.before) / 2;
  return {.begin = std::max(begin, end - std::min(end, longest)), .end = end, .dragged = 0.3 * most / static_cast<double>(width)};
}

/// The best ringing before a bin: it begins at `rho` and grows to `level` events per bin.
struct Ringing {
  double log_likelihood = -infinite, level = 0;
  std::size_t rho = 0;
};

Ringing best_ringing(Counts counts, const Sums& sums, std::size_t tau, std::size_t per_ms, double quiet, double dragged) {
  Ringing best;
  for (const std::size_t ms : {1U, 2U, 3U, 4U, 5U, 6U, 8U, 10U, 12U, 15U, 18U, 22U, 27U, 33U, 40U, 48U, 60U}) {
    if (ms * per_ms > tau) break;
    const std::size_t rho = tau - ms * per_ms;
    const auto n = static_cast<double>(tau - rho);
    const double events = sums.of(rho, tau), expected = quiet * n;
    if (events <= expected) continue;
    const double gradient = std::min((events - expected) / (0.5 * n * n), 0.5 * dragged / n);
    double likelihood = log_likelihood_of(sums.of(0, rho), static_cast<double>(rho), quiet);
    for (std::size_t i = rho; i < tau; ++i) {
      const double expect = quiet + gradient * (static_cast<double>(i - rho) + 0.5);
      likelihood += (counts[i] > 0 ? counts[i] * std::log(expect) : 0.0) - expect;
    }
    if (likelihood > best.log_likelihood) best = {likelihood, gradient * n, rho};
  }
  return best;
}

/// A slip's onset with ringing and without, and which of them holds.
Scan slip_scan(const LitRate& lit, const SlipRange& range, std::size_t width, bool may_ring) {
  constexpr double price = 4.0;  // of two more free numbers
  const Counts counts = Counts(lit.rate.counts).subspan(range.begin, range.end - range.begin);
  const Sums sums(counts);
  const std::size_t n = counts.size();
  const double quiet = std::max(lit.quiet_per_bin, half_event_per(n));
  const std::vector<Filled> filled = filled_bins(counts);
  const std::vector<double> plain = rise_likelihoods(counts, quiet);
  if (!may_ring) {
    const Scan scan = scan_of(plain, lit.dispersion);
    return {range.begin + scan.best, range.begin + scan.low, range.begin + scan.high};
  }
  std::vector<double> ringing(n, -infinite);
  std::vector<std::size_t> rung_from(n);
  for (std::size_t tau = 0; tau < n; ++tau) {
    const Ringing best = best_ringing(counts, sums, tau, width, quiet, range.dragged);
    rung_from[tau] = best.rho;
    if (best.log_likelihood > log_likelihood_of(sums.of(0, tau), static_cast<double>(tau), quiet))
      ringing[tau] = best.log_likelihood + best_rise(filled_from(filled, tau), tau, n, quiet + best.level);
  }
  const Scan scan = scan_of(plain, lit.dispersion), rung = scan_of(ringing, lit.dispersion);
  const double gain = ringing[rung.best] - plain[scan.best];
  Scan chosen = gain > price * lit.dispersion ? rung : scan;
  if (std::abs(gain) <= price * lit.dispersion) {
    chosen.low = std::min(scan.low, rung.low);
    chosen.high = std::max(scan.high, rung.high);
  }
  // Ringing with a good part of the rate that follows may be a drag that began slowly.
  if (chosen.best == rung.best && gain > 0) {
    const Sums all(lit.rate.counts);
    const std::size_t gap = width / 5, at = range.begin + chosen.best;
    const auto mean = [&](std::size_t from, std::size_t to) {
      return to > from && to <= lit.rate.counts.size() ? all.of(from, to) / static_cast<double>(to - from) : 0.0;
    };
    const double before = mean(at - std::min(at, width + gap), at - std::min(at, gap)) - quiet;
    const double after = mean(at + 3 * width, at + 5 * width) - quiet;
    if (before > 0.05 * after) chosen.low = std::min(chosen.low, rung_from[rung.best]);
  }
  return {range.begin + chosen.best, range.begin + chosen.low, range.begin + chosen.high};
}

}  // namespace

FoundTime slip_onset(const LitRate& lit, const OnsetOptions& options, const std::optional<alignment::UncertainTime>& lift_start,
                     std::optional<bool> arm_rings) {
  const alignment::EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t width = std::max<std::size_t>(1, bins(1ms));
  const Scan scan = slip_scan(lit, slip_range(lit, width, options, lift_start), width, arm_rings.value_or(true));
  FoundTime onset = found_at(lit, scan, rate.counts, lit.repeats, 1.0, options);
  if (const auto jump = sharper_jump(lit, scan.best, width, bins(options.first_drag))) {
    onset.time.high = std::max(onset.time.high, after(rate.begin_of(*jump), rate.bin));
    if (arm_rings.value_or(false))
      onset.doubt =
          doubt("onset-ringing", "its onset may be the arm's ringing: it begins gradually, and a sharper rise follows soon");
  }
  return onset;
}

}  // namespace tactile::labels
