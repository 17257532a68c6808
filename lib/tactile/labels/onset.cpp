#include "tactile/labels/onset.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

/// The best b, c >= 0 of rate = base + b + c x, x in bins from the stretch's begin, and its log-likelihood. Newton's method on a
/// concave function, kept inside b, c >= 0.
struct Rise {
  double b = 0, c = 0;
  double log_likelihood = minus_infinity;
};

Rise best_rise(Counts counts, double base) {
  const auto n = static_cast<double>(counts.size());
  double events = 0;
  for (const std::uint32_t count : counts) events += count;
  const double x_sum = 0.5 * n * n;
  const auto fit = [&](bool with_b, bool with_c) {
    // Start from what a flat or an even rise would need.
    Rise rise{.b = with_b ? std::max(1e-3, (events / n - base) * (with_c ? 0.5 : 1.0)) : 0.0,
              .c = with_c ? std::max(1e-3 / n, (events - base * n) / x_sum * (with_b ? 0.5 : 1.0)) : 0.0};
    for (int step = 0; step < 30; ++step) {
      double gb = -n, gc = -x_sum, hbb = 1e-12, hbc = 0, hcc = 1e-12;
      for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        const double x = static_cast<double>(i) + 0.5;
        const double w = 1.0 / (base + rise.b + rise.c * x), cw = counts[i] * w;
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
    double likelihood = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double rate = base + rise.b + rise.c * (static_cast<double>(i) + 0.5);
      likelihood += (counts[i] > 0 ? counts[i] * std::log(rate) : 0.0) - rate;
    }
    rise.log_likelihood = likelihood;
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
microseconds blind_ahead_of(const LitRate& lit, std::size_t onset, const OnsetOptions& options) {
  constexpr std::uint32_t enough = 3;  // not one pixel alone, which might be noise
  const auto most = static_cast<std::size_t>(options.longest_blind / lit.rate.bin);
  std::uint32_t repeats = 0;
  std::size_t i = onset;
  for (; i < lit.repeats.size() && i < onset + most && repeats < enough; ++i) repeats += lit.repeats[i];
  return lit.rate.bin * static_cast<std::int64_t>(i - onset);
}

/// A bin's events were caused since the read-out before it.
FoundTime found(const LitRate& lit, const Scan& scan, const OnsetOptions& options) {
  const EventRate& rate = lit.rate;
  const microseconds blind = std::max(options.latency, blind_ahead_of(lit, scan.best, options));
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

}  // namespace

FoundTime press_onset(const LitRate& lit, const OnsetOptions& options) {
  const EventRate& rate = lit.rate;
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t begin = lit.burst_begin - std::min(lit.burst_begin, bins(options.first_contact + options.before));
  const Counts all = Counts(rate.counts).subspan(begin);
  const Sums sums(all);
  const double floor = 0.5 / static_cast<double>(all.size());
  const double quiet = std::max(lit.quiet_per_bin, floor);

  // Up to where the events above the quiet rate stand out beyond doubt (Page's cumulative sum). What a burst does later says
  // nothing about its begin, but would bend the fit, for its counts are the largest.
  std::size_t end = all.size();
  {
    const double allowance = quiet + 0.5 * std::sqrt(lit.dispersion * quiet);
    double excess = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      excess = std::max(0.0, excess + all[i] - allowance);
      if (excess >= 40.0 * lit.dispersion &&
          i >= lit.burst_begin - begin - std::min(lit.burst_begin - begin, bins(options.first_contact))) {
        end = i + 1;
        break;
      }
    }
  }
  const std::size_t from = end - std::min(end, bins(options.before) * 2);
  const Counts telling = all.subspan(from, end - from);
  const Sums told(telling);
  std::vector<double> likelihood(telling.size());
  for (std::size_t tau = 0; tau < telling.size(); ++tau) {
    likelihood[tau] = log_likelihood_of(told.of(0, tau), static_cast<double>(tau), quiet) +
                      best_rise(telling.subspan(tau), quiet).log_likelihood;
  }
  Scan scan = scan_of(likelihood, lit.dispersion);
  scan.best += from;
  scan.low += from;
  scan.high += from;

  // Did a weaker contact come first?
  constexpr double sure = 7.0, likely = 4.0;
  for (int earlier = 0; earlier < 4; ++earlier) {
    const std::size_t until = scan.low;
    if (until < 2) break;
    std::vector<double> gain(until);
    for (std::size_t tau = 0; tau < until; ++tau) {
      const double events = sums.of(tau, until), expected = quiet * static_cast<double>(until - tau);
      gain[tau] = events > expected ? events * std::log(events / expected) - (events - expected) : 0.0;
    }
    const Scan step = scan_of(gain, lit.dispersion);
    const double best = gain[step.best] / lit.dispersion;
    if (best < likely) break;
    scan.low = step.low;
    if (best < sure) break;
    scan.best = step.best;
    scan.high = step.high;
  }
  return found(lit, {begin + scan.best, begin + scan.low, begin + scan.high}, options);
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

  std::vector<double> plain(n), ringing(n, minus_infinity);
  std::vector<std::size_t> rung_from(n);
  const std::size_t step = width;
  for (std::size_t tau = 0; tau < n; ++tau) {
    const double ahead = log_likelihood_of(sums.of(0, tau), static_cast<double>(tau), quiet);
    plain[tau] = ahead + best_rise(counts.subspan(tau), quiet).log_likelihood;
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
    if (best_ahead > ahead) ringing[tau] = best_ahead + best_rise(counts.subspan(tau), quiet + level).log_likelihood;
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
  FoundTime onset = found(lit, {begin + chosen.best, begin + chosen.low, begin + chosen.high}, options);
  if (const auto jump = sharper_jump(lit, begin + chosen.best, width, bins(options.first_drag))) {
    onset.time.high = std::max(onset.time.high, after(rate.begin_of(*jump), rate.bin));
    onset.doubt = "its onset may be the arm's ringing: it begins gradually, and a sharper rise follows soon";
  }
  return onset;
}

}  // namespace tactile
