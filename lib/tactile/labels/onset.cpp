#include "tactile/labels/onset.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace tactile::labels {
namespace {

constexpr double minus_infinity = -std::numeric_limits<double>::infinity();

using Counts = std::span<const std::uint32_t>;

/// Sums of counts between bins in constant time.
class Sums {
 public:
  explicit Sums(Counts counts) : until_(counts.size() + 1) {
    for (std::size_t i = 0; i < counts.size(); ++i) until_[i + 1] = until_[i] + counts[i];
  }
  double of(std::size_t begin, std::size_t end) const { return until_[end] - until_[begin]; }

 private:
  std::vector<double> until_;
};

/// sum of n ln(rate) - rate, without the terms of the counts alone.
double log_likelihood_of(double events, double bins, double rate) { return events * std::log(rate) - rate * bins; }

/// A bin that holds events. Of the others only the number matters.
struct Filled {
  double at = 0, count = 0;
};

std::vector<Filled> filled_bins(Counts counts) {
  std::vector<Filled> filled;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) filled.push_back({static_cast<double>(i), static_cast<double>(counts[i])});
  }
  return filled;
}

/// Those from bin `from` on.
std::span<const Filled> filled_from(const std::vector<Filled>& filled, std::size_t from) {
  const auto first = std::partition_point(filled.begin(), filled.end(),
                                          [from](const Filled& bin) { return bin.at < static_cast<double>(from); });
  return {first, filled.end()};
}

/// The best b, c >= 0 of rate = base + b + c x, with x in bins from the stretch's begin, and its log-likelihood.
struct Rise {
  double b = 0, c = 0;
  double log_likelihood = minus_infinity;
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

double best_rise(std::span<const Filled> filled, std::size_t from, std::size_t to, double base) {
  double best = minus_infinity;
  for (const auto& [with_b, with_c] : {std::pair{true, false}, {false, true}, {true, true}})
    best = std::max(best, fit_rise(filled, from, to, base, with_b, with_c).log_likelihood);
  return best;
}

/// The best bin of a scan and its 95 % interval, each as the first bin after the change.
struct Scan {
  std::size_t best = 0, low = 0, high = 0;
};

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

/// The events of a bin were caused since the read-out before it.
/// @param counts, repeats  of the place where it begins
FoundTime found_at(const LitRate& lit, const Scan& scan, Counts counts, Counts repeats, const OnsetOptions& options) {
  const alignment::EventRate& rate = lit.rate;
  const auto more = static_cast<double>((options.blind_reset - options.longest_blind).count());
  const microseconds longest = options.longest_blind + microseconds{std::llround(lit.reset_share * more)};
  const microseconds blind = std::max(options.latency, blind_time_before(rate.bin, counts, repeats, scan.best, longest));
  FoundTime result{.time = {.at = before(rate.begin_of(scan.best), rate.bin / 2),
                            .low = before(rate.begin_of(scan.low), rate.bin + blind),
                            .high = after(rate.begin_of(scan.high), rate.bin / 2)},
                   .doubt = {}};
  const double width_ms = 1e-3 * static_cast<double>(between(result.time.low, result.time.high).count());
  if (width_ms > options.too_wide_ms) result.doubt = fmt::format("its onset is only known to within {:.0f} ms", width_ms);
  return result;
}

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

/// Up to where the events above the quiet rate stand out clearly (Page's cumulative sum). Later events say nothing about the
/// begin of a burst, but would distort the fit, since their counts are the largest.
/// @param from  the first bin that may be returned
std::size_t clear_by(Counts counts, double quiet, double dispersion, std::size_t from) {
  constexpr double sure = 40.0;  // events
  const double allowance = quiet + 0.5 * std::sqrt(dispersion * quiet);
  double excess = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    excess = std::max(0.0, excess + counts[i] - allowance);
    if (excess >= sure * dispersion && i >= from) return i + 1;
  }
  return counts.size();
}

/// How much likelier so many events are at their own rate than at the expected; 0 where they are fewer.
double gain_of(double events, double expected) {
  return events > expected ? events * std::log(events / expected) - (events - expected) : 0.0;
}

/// Counts that may hold an earlier contact than the found one: of a place, or of all places.
struct Candidate {
  Counts counts;
  double quiet = 0, dispersion = 1;
  Sums sums;
};

/// A step of the rate before bin `until`, and how much likelier it is than none.
struct Step {
  Scan scan;
  double gain = 0;
};

/// @param from  not earlier than this
Step step_before(const Candidate& candidate, std::size_t from, std::size_t until) {
  // A place untouched has the rate of just before, where that is more.
  double quiet = candidate.quiet;
  if (from > 0) quiet = std::max(quiet, candidate.sums.of(0, from) / static_cast<double>(from));
  std::vector<double> gain(until, minus_infinity);
  for (std::size_t tau = from; tau < until; ++tau) {
    const double events = candidate.sums.of(tau, until), expected = quiet * static_cast<double>(until - tau);
    gain[tau] = gain_of(events, expected);
  }
  const Scan scan = scan_of(gain, candidate.dispersion);
  return {.scan = scan, .gain = gain[scan.best] / candidate.dispersion};
}

/// Whether weaker contacts came before the one that was found. The noise of all markers hides one that is touched, its own noise
/// does not. Moves the scan to the earliest contact that is sure.
void look_before(Scan& scan, const std::vector<Candidate>& candidates, std::size_t reach) {
  // Among many places one shows a clump by chance more easily.
  const double among = std::log(static_cast<double>(candidates.size()));
  const double sure = 7.0 + among, likely = 4.0 + among;
  for (int earlier = 0; earlier < 8; ++earlier) {
    const std::size_t until = scan.low;
    if (until < 2) return;
    bool is_sure = false;
    Step most;
    std::size_t low = until;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Step step = step_before(candidates[i], i == 0 ? 0 : until - std::min(until, reach), until);
      if (step.gain < likely) continue;
      low = std::min(low, step.scan.low);
      if (step.gain < sure || step.gain <= most.gain) continue;
      is_sure = true;
      most = step;
    }
    if (!is_sure) {
      scan.low = low;
      return;
    }
    scan = most.scan;
  }
}

/// The likelihood that the rate begins to rise at each bin.
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

double half_event_per(std::size_t bins) { return 0.5 / static_cast<double>(std::max<std::size_t>(bins, 1)); }

/// Where a slip's onset is searched: bins [begin, end) of its burst's rate.
struct SlipRange {
  std::size_t begin = 0, end = 0;
  double dragged = 0;  ///< events per bin: the rate of a drag
};

/// Up to where the rate first has 0.3 of what the first drag reaches: the drag is on by then. That drag is looked for from where
/// more than ringing is on; what later jerks reach does not matter.
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
  double log_likelihood = minus_infinity, level = 0;
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
  std::vector<double> ringing(n, minus_infinity);
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

FoundTime press_onset(const LitRate& lit, const OnsetOptions& options) {
  const alignment::EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t begin = lit.burst_begin - std::min(lit.burst_begin, bins(options.first_contact + options.before));
  const Counts all = Counts(rate.counts).subspan(begin);
  const double floor = half_event_per(all.size()), quiet = std::max(lit.quiet_per_bin, floor);
  const std::size_t ahead = lit.burst_begin - begin;
  const std::size_t end = clear_by(all, quiet, lit.dispersion, ahead - std::min(ahead, bins(options.first_contact)));
  const std::size_t from = end - std::min(end, bins(options.before) * 2);
  Scan scan = scan_of(rise_likelihoods(all.subspan(from, end - from), quiet), lit.dispersion);
  scan = {scan.best + from, scan.low + from, scan.high + from};

  std::vector<Candidate> candidates;
  candidates.push_back({all, quiet, lit.dispersion, Sums(all)});
  for (const LitPlace& place : lit.places) {
    const Counts counts = Counts(place.counts).subspan(begin);
    candidates.push_back({counts, std::max(place.quiet_per_bin, floor), place.dispersion, Sums(counts)});
  }
  look_before(scan, candidates, bins(options.before));

  // The place of the first events shows for how long its pixels were blind.
  Counts counts = rate.counts, repeats = lit.repeats;
  double most = 0;
  for (std::size_t i = 0; i < lit.places.size(); ++i) {
    const double gain =
        gain_of(candidates[i + 1].sums.of(scan.best, end), candidates[i + 1].quiet * static_cast<double>(end - scan.best));
    if (gain <= most) continue;
    most = gain;
    counts = lit.places[i].counts;
    repeats = lit.places[i].repeats;
  }
  return found_at(lit, {begin + scan.best, begin + scan.low, begin + scan.high}, counts, repeats, options);
}

FoundTime slip_onset(const LitRate& lit, const OnsetOptions& options, const std::optional<alignment::UncertainTime>& lift_start,
                     std::optional<bool> arm_rings) {
  const alignment::EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t width = std::max<std::size_t>(1, bins(1ms));
  const Scan scan = slip_scan(lit, slip_range(lit, width, options, lift_start), width, arm_rings.value_or(true));
  FoundTime onset = found_at(lit, scan, rate.counts, lit.repeats, options);
  if (const auto jump = sharper_jump(lit, scan.best, width, bins(options.first_drag))) {
    onset.time.high = std::max(onset.time.high, after(rate.begin_of(*jump), rate.bin));
    if (arm_rings.value_or(false))
      onset.doubt = "its onset may be the arm's ringing: it begins gradually, and a sharper rise follows soon";
  }
  return onset;
}

}  // namespace tactile::labels
