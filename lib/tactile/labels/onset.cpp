#include "tactile/labels/onset.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace tactile {
namespace {

constexpr double half_chi2 = 1.92;  // half of the 95 % point of chi^2 with one degree of freedom
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

/// A bin that holds events; the others need no more than their number.
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

/// The best b, c >= 0 of rate = base + b + c x, x in bins from the stretch's begin, and its log-likelihood. Newton's method on a
/// concave function, kept inside b, c >= 0.
struct Rise {
  double b = 0, c = 0;
  double log_likelihood = minus_infinity;
};

/// @param filled  of the bins [from, to)
Rise best_rise(std::span<const Filled> filled, std::size_t from, std::size_t to, double base) {
  const auto n = static_cast<double>(to - from);
  const double first = static_cast<double>(from) - 0.5;
  double events = 0;
  for (const Filled& bin : filled) events += bin.count;
  const double x_sum = 0.5 * n * n;
  const auto fit = [&](bool with_b, bool with_c) {
    // Start from what a flat or an even rise would need.
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
      double db = 0, dc = 0;
      if (with_b && with_c) {
        const double det = hbb * hcc - hbc * hbc;
        if (det > 1e-9 * hbb * hcc) {
          db = (hcc * gb - hbc * gc) / det;
          dc = (hbb * gc - hbc * gb) / det;
        } else {
          db = gb / hbb;
        }
      } else if (with_b) {
        db = gb / hbb;
      } else {
        dc = gc / hcc;
      }
      const double b = std::max(with_b ? 0.1 * rise.b : 0.0, rise.b + db), c = std::max(with_c ? 0.1 * rise.c : 0.0, rise.c + dc);
      const double moved = std::abs(b - rise.b) + n * std::abs(c - rise.c);
      rise.b = b;
      rise.c = c;
      if (moved < 1e-4 * (base + b + n * c)) break;
    }
    rise.log_likelihood = -(base + rise.b) * n - rise.c * x_sum;
    for (const Filled& bin : filled) rise.log_likelihood += bin.count * std::log(base + rise.b + rise.c * (bin.at - first));
    return rise;
  };
  const Rise flat = fit(true, false), even = fit(false, true), both = fit(true, true);
  const Rise& one = flat.log_likelihood >= even.log_likelihood ? flat : even;
  return both.log_likelihood > one.log_likelihood ? both : one;
}

/// Bins of a scan, its best and its 95 % interval, all as the first bin behind the change.
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

/// A pixel that has to undo its last change is blind for a while: for as long as the first ones take, once they fire, from one
/// event to the next. By so much a marker may have moved ahead of its first events.
microseconds blind_ahead_of(microseconds bin, Counts counts, Counts repeats, std::size_t onset, microseconds longest) {
  if (repeats.size() != counts.size()) return 0us;  // nobody has counted them
  constexpr double enough = 3.0;  // not one pixel alone, which might be noise
  const auto most = static_cast<std::size_t>(longest / bin);
  // So many events follow one of their pixel's noise by chance.
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

/// A bin's events were caused since the read-out before it.
/// @param counts, repeats  of the place that it begins at
FoundTime found(const LitRate& lit, const Scan& scan, Counts counts, Counts repeats, const OnsetOptions& options) {
  const EventRate& rate = lit.rate;
  const auto more = static_cast<double>((options.blind_anew - options.longest_blind).count());
  const microseconds longest = options.longest_blind + microseconds{std::llround(lit.set_anew * more)};
  const microseconds blind = std::max(options.latency, blind_ahead_of(rate.bin, counts, repeats, scan.best, longest));
  FoundTime result{.time = {.at = before(rate.begin_of(scan.best), rate.bin / 2),
                            .low = before(rate.begin_of(scan.low), rate.bin + blind),
                            .high = after(rate.begin_of(scan.high), rate.bin / 2)},
                   .doubt = {}};
  const double width_ms = 1e-3 * static_cast<double>(between(result.time.low, result.time.high).count());
  if (width_ms > options.too_wide_ms) result.doubt = fmt::format("its onset is only known to within {:.0f} ms", width_ms);
  return result;
}

/// A drag begins at a speed. What begins gradually, and gives way to a sharper jump soon, may have been ringing as strong as a
/// drag: that jump then, if there is one.
std::optional<std::size_t> sharper_jump(const LitRate& lit, std::size_t onset, std::size_t width, std::size_t within) {
  const Sums sums(lit.rate.counts);
  const std::size_t n = lit.rate.counts.size(), gap = width / 5;
  if (onset < width + gap || onset + 5 * width > n) return std::nullopt;
  const auto rise_at = [&](std::size_t at) {  // of the rate's root, whose noise is the same for all rates
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

/// The first bin of what begins a slip. A few tips that spring back before the lift are a stretch of their own: behind it all is
/// quiet for long, and it is small against what comes then.
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

/// Up to where the events above the quiet rate stand out beyond doubt (Page's cumulative sum). What a burst does later says
/// nothing about its begin, but would bend the fit, for its counts are the largest.
/// @param from  the first bin in which it may be sure
std::size_t surely_by(Counts counts, double quiet, double dispersion, std::size_t from) {
  constexpr double sure = 40.0;  // events
  const double allowance = quiet + 0.5 * std::sqrt(dispersion * quiet);
  double excess = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    excess = std::max(0.0, excess + counts[i] - allowance);
    if (excess >= sure * dispersion && i >= from) return i + 1;
  }
  return counts.size();
}

/// What is asked whether a contact came ahead of the one that was found: a place, or all of them.
struct Asked {
  Counts counts;
  double quiet = 0, dispersion = 1;
  Sums sums;
};

/// A step of the rate ahead of bin `until`, and by how much it is likelier than none.
struct Step {
  Scan scan;
  double gain = 0;
};

/// @param from  not earlier than this
Step step_ahead(const Asked& asked, std::size_t from, std::size_t until) {
  // What a place did just before is what it does untouched, where that is more.
  double quiet = asked.quiet;
  if (from > 0) quiet = std::max(quiet, asked.sums.of(0, from) / static_cast<double>(from));
  std::vector<double> gain(until, minus_infinity);
  for (std::size_t tau = from; tau < until; ++tau) {
    const double events = asked.sums.of(tau, until), expected = quiet * static_cast<double>(until - tau);
    gain[tau] = events > expected ? events * std::log(events / expected) - (events - expected) : 0.0;
  }
  const Scan scan = scan_of(gain, asked.dispersion);
  return {.scan = scan, .gain = gain[scan.best] / asked.dispersion};
}

}  // namespace

FoundTime press_onset(const LitRate& lit, const OnsetOptions& options) {
  const EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t begin = lit.burst_begin - std::min(lit.burst_begin, bins(options.first_contact + options.before));
  const Counts all = Counts(rate.counts).subspan(begin);
  const double floor = 0.5 / static_cast<double>(all.size());
  const double quiet = std::max(lit.quiet_per_bin, floor);
  const std::size_t ahead = lit.burst_begin - begin;
  const std::size_t end = surely_by(all, quiet, lit.dispersion, ahead - std::min(ahead, bins(options.first_contact)));
  const std::size_t from = end - std::min(end, bins(options.before) * 2);
  const Counts telling = all.subspan(from, end - from);
  const Sums told(telling);
  const std::vector<Filled> filled = filled_bins(telling);
  std::vector<double> likelihood(telling.size());
  for (std::size_t tau = 0; tau < telling.size(); ++tau) {
    likelihood[tau] = log_likelihood_of(told.of(0, tau), static_cast<double>(tau), quiet) +
                      best_rise(filled_from(filled, tau), tau, telling.size(), quiet).log_likelihood;
  }
  Scan scan = scan_of(likelihood, lit.dispersion);
  scan.best += from;
  scan.low += from;
  scan.high += from;

  // Did a weaker contact come first? One marker that is touched is hidden by the noise of all of them, but not by its own.
  std::vector<Asked> asked;
  asked.push_back({all, quiet, lit.dispersion, Sums(all)});
  for (const LitPlace& place : lit.places) {
    const Counts counts = Counts(place.counts).subspan(begin);
    asked.push_back({counts, std::max(place.quiet_per_bin, floor), place.dispersion, Sums(counts)});
  }
  // Of many places one shows a clump by chance more easily.
  const double among = std::log(static_cast<double>(asked.size()));
  const double sure = 7.0 + among, likely = 4.0 + among;
  for (int earlier = 0; earlier < 8; ++earlier) {
    const std::size_t until = scan.low;
    if (until < 2) break;
    std::optional<std::size_t> surest;
    Step most;
    std::size_t low = until;
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const Step step = step_ahead(asked[i], i == 0 ? 0 : until - std::min(until, bins(options.before)), until);
      if (step.gain < likely) continue;
      low = std::min(low, step.scan.low);
      if (step.gain < sure || step.gain <= most.gain) continue;
      surest = i;
      most = step;
    }
    if (!surest) {
      scan.low = low;
      break;
    }
    scan = most.scan;
  }
  // The place whose first events these are tells for how long its pixels were blind.
  Counts counts = rate.counts, repeats = lit.repeats;
  double most = 0;
  for (std::size_t i = 0; i < lit.places.size(); ++i) {
    const Asked& place = asked[i + 1];
    const double events = place.sums.of(scan.best, end), expected = place.quiet * static_cast<double>(end - scan.best);
    const double gain = events > expected ? events * std::log(events / expected) - (events - expected) : 0.0;
    if (gain <= most) continue;
    most = gain;
    counts = lit.places[i].counts;
    repeats = lit.places[i].repeats;
  }
  return found(lit, {begin + scan.best, begin + scan.low, begin + scan.high}, counts, repeats, options);
}

FoundTime slip_onset(const LitRate& lit, const OnsetOptions& options, const std::optional<UncertainTime>& lift_start) {
  const EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t first = slip_begin(lit);
  std::size_t begin = first - std::min(first, bins(options.before));
  if (lift_start && lift_start->low > rate.begin_of(begin)) {
    const auto earliest = static_cast<std::size_t>(between(rate.begin, lift_start->low) / rate.bin);
    begin = std::min(earliest, first);
  }

  // Up to where the rate first has 0.3 of what the first drag reaches: it is on by then, and has told all about its begin. That
  // drag is looked for from where more than ringing is on; what later jerks reach does not matter.
  const Sums all(rate.counts);
  const std::size_t width = std::max<std::size_t>(1, bins(1ms));
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
  begin = std::max(begin, end - std::min(end, bins(options.before) + bins(options.before) / 2));
  const Counts counts = Counts(rate.counts).subspan(begin, end - begin);
  const Sums sums(counts);
  const std::size_t n = counts.size();
  const double floor = 0.5 / static_cast<double>(std::max<std::size_t>(n, 1));
  const double quiet = std::max(lit.quiet_per_bin, floor);
  const double dragged = 0.3 * most / static_cast<double>(width);

  const std::vector<Filled> filled = filled_bins(counts);
  std::vector<double> plain(n), ringing(n, minus_infinity);
  std::vector<std::size_t> rung_from(n);
  const std::size_t step = width;
  for (std::size_t tau = 0; tau < n; ++tau) {
    const double ahead = log_likelihood_of(sums.of(0, tau), static_cast<double>(tau), quiet);
    plain[tau] = ahead + best_rise(filled_from(filled, tau), tau, n, quiet).log_likelihood;
    // The ringing that suits what is ahead of tau best.
    double best_ahead = minus_infinity, level = 0;
    // From so many milliseconds ago on.
    for (const std::size_t ms : {1U, 2U, 3U, 4U, 5U, 6U, 8U, 10U, 12U, 15U, 18U, 22U, 27U, 33U, 40U, 48U, 60U}) {
      if (ms * step > tau) break;
      const std::size_t rho = tau - ms * step;
      const double events = sums.of(rho, tau), expected = quiet * static_cast<double>(tau - rho);
      if (events <= expected) continue;
      const double m = static_cast<double>(tau - rho);
      const double slope = std::min((events - expected) / (0.5 * m * m), 0.5 * dragged / m);
      double here = log_likelihood_of(sums.of(0, rho), static_cast<double>(rho), quiet);
      for (std::size_t i = rho; i < tau; ++i) {
        const double expect = quiet + slope * (static_cast<double>(i - rho) + 0.5);
        here += (counts[i] > 0 ? counts[i] * std::log(expect) : 0.0) - expect;
      }
      if (here > best_ahead) {
        best_ahead = here;
        rung_from[tau] = rho;
        level = slope * m;
      }
    }
    if (best_ahead > ahead) ringing[tau] = best_ahead + best_rise(filled_from(filled, tau), tau, n, quiet + level).log_likelihood;
  }
  constexpr double price = 4.0;  // of two more free numbers
  const Scan scan = scan_of(plain, lit.dispersion);
  Scan rung = scan_of(ringing, lit.dispersion);
  const double gain = ringing[rung.best] - plain[scan.best];
  Scan chosen = gain > price * lit.dispersion ? rung : scan;
  if (std::abs(gain) <= price * lit.dispersion) {
    chosen.low = std::min(scan.low, rung.low);
    chosen.high = std::max(scan.high, rung.high);
  }
  // Ringing that has a good part of what follows may be a drag that began slowly.
  if (chosen.best == rung.best && gain > 0) {
    const std::size_t gap = width / 5;
    const auto mean = [&](std::size_t from, std::size_t to) {
      return to > from && to <= rate.counts.size() ? all.of(from, to) / static_cast<double>(to - from) : 0.0;
    };
    const std::size_t at = begin + chosen.best;
    const double ahead = mean(at - std::min(at, width + gap), at - std::min(at, gap)) - quiet;
    const double behind = mean(at + 3 * width, at + 5 * width) - quiet;
    if (ahead > 0.05 * behind) chosen.low = std::min(chosen.low, rung_from[rung.best]);
  }
  FoundTime onset = found(lit, {begin + chosen.best, begin + chosen.low, begin + chosen.high}, rate.counts, lit.repeats, options);
  if (const auto jump = sharper_jump(lit, begin + chosen.best, width, bins(options.first_drag))) {
    onset.time.high = std::max(onset.time.high, after(rate.begin_of(*jump), rate.bin));
    onset.doubt = "its onset may be the arm's ringing: it begins gradually, and a sharper rise follows soon";
  }
  return onset;
}

}  // namespace tactile
