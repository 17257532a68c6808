#include "tactile/labels/touch_end.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tactile/alignment/moving_mean.hpp"

namespace tactile::labels {
namespace {

/// The rate in steps of a whole number of bins, from the onset on, in events per step.
struct Steps {
  CameraTime begin{};
  microseconds step{};
  std::vector<double> events;
  double quiet = 0;  ///< per step

  CameraTime time_of(double index) const {
    return after(begin, microseconds{std::llround(index * static_cast<double>(step.count()))});
  }
  std::size_t in(microseconds span) const {
    return static_cast<std::size_t>(std::max<std::int64_t>(1, (span.count() + step.count() / 2) / step.count()));
  }
};

Steps steps_from(const LitRate& lit, CameraTime onset, microseconds wanted) {
  const alignment::EventRate& rate = lit.rate;
  const std::int64_t per_step = std::max<std::int64_t>(1, wanted / rate.bin);
  const auto first = static_cast<std::size_t>(
      std::clamp<std::int64_t>(between(rate.begin, onset) / rate.bin, 0, static_cast<std::int64_t>(rate.counts.size())));
  // The events of a read-out were caused since the one before it.
  Steps steps{.begin = before(rate.begin_of(first), rate.bin / 2),
              .step = rate.bin * per_step,
              .events = {},
              .quiet = lit.quiet_per_bin * static_cast<double>(per_step)};
  const auto n = static_cast<std::size_t>(per_step);
  for (std::size_t i = first; i + n <= rate.counts.size(); i += n) {
    double sum = 0;
    for (std::size_t k = i; k < i + n; ++k) sum += rate.counts[k];
    steps.events.push_back(sum);
  }
  return steps;
}

/// The first step of the first stretch of `still` in which `rates` stays below `limit`, from `begin` on.
std::size_t still_from(const std::vector<double>& rates, std::size_t begin, double limit, std::size_t still) {
  std::size_t since = begin;
  for (std::size_t i = begin; i < rates.size(); ++i) {
    if (rates[i] >= limit) since = i + 1;
    if (i + 1 >= since + still) break;
  }
  return std::min(since, rates.size());
}

double least_limit(const Steps& steps, double dispersion, std::size_t width, double deviations) {
  const double n = static_cast<double>(width);
  return deviations * std::sqrt(dispersion * std::max(steps.quiet, 0.5 / n) / n) + 0.5 / n;
}

void check_width(FoundTime& end, const EndOptions& options) {
  const double width_ms = 1e-3 * static_cast<double>(between(end.time.low, end.time.high).count());
  if (width_ms > options.too_wide_ms && end.doubt.empty())
    end.doubt = doubt("end-width", "its end is only known to within {:.0f} ms", width_ms);
}

/// An interval has a length: its end is a bin after its onset at least.
void end_after(const alignment::UncertainTime& onset, microseconds bin, alignment::UncertainTime& end) {
  end.at = std::max(end.at, after(onset.at, bin));
  end.low = std::max(end.low, onset.low);
  end.high = std::max(end.high, end.at);
}

/// The best z + g shape for given shapes, both >= 0, by expectation maximisation, which keeps them so.
double best_mix(std::span<const double> events, std::span<const double> shape, double& z, double& g) {
  double shape_sum = 0;
  for (const double s : shape) shape_sum += s;
  const auto n = static_cast<double>(events.size());
  double likelihood = -std::numeric_limits<double>::infinity();
  for (int round = 0; round < 40; ++round) {
    double to_z = 0, to_g = 0, now = -z * n - g * shape_sum;
    for (std::size_t i = 0; i < events.size(); ++i) {
      if (!(events[i] > 0)) continue;
      const double rate = z + g * shape[i];
      now += events[i] * std::log(rate);
      to_z += events[i] * z / rate;
      to_g += events[i] * g * shape[i] / rate;
    }
    if (now - likelihood < 1e-3) return now;
    likelihood = now;
    z = std::max(1e-6, to_z / n);
    g = shape_sum > 0 ? std::max(1e-12, to_g / shape_sum) : 0.0;
  }
  return likelihood;
}

/// The end of a burst, in whole steps from the onset.
std::size_t burst_steps(const LitRate& lit, const Steps& steps) {
  const CameraTime end = lit.rate.begin_of(lit.burst_end);
  return static_cast<std::size_t>(std::max<std::int64_t>(0, between(steps.begin, end) / steps.step));
}

/// The end of a touch that has too few steps for one.
FoundTime unknown_end(const LitRate& lit, const alignment::UncertainTime& onset) {
  const CameraTime end = std::max(after(onset.at, lit.rate.bin), lit.rate.begin_of(lit.burst_end));
  return {.time = {.at = end, .low = onset.at, .high = end},
          .doubt = doubt("end-at-onset", "its end cannot be distinguished from its onset")};
}

/// The decline of a press: its peak above the quiet rate, and the step where it has faded into the noise for long enough.
struct Decline {
  double peak = 0;
  std::size_t faded = 0;
};

Decline decline_of(const Steps& steps, const std::vector<double>& rates, std::size_t searched, double dispersion,
                   const EndOptions& options) {
  Decline decline;
  for (int round = 0; round < 3; ++round) {
    // The peak of the motion before the first stillness: a micro-slip later is no part of it.
    const std::size_t until = round == 0 ? searched : std::max<std::size_t>(decline.faded, 1);
    const auto top = std::max_element(rates.begin(), rates.begin() + static_cast<std::ptrdiff_t>(until));
    decline.peak = std::max(1e-6, *top - steps.quiet);
    const double limit = steps.quiet + std::max(0.04 * decline.peak, least_limit(steps, dispersion, steps.in(5ms), 3.0));
    // Some first contacts are weak and pause: stillness counts from a tenth of the peak on.
    std::size_t from = 0;
    while (from < until && rates[from] < steps.quiet + 0.1 * decline.peak) ++from;
    decline.faded = still_from(rates, std::min(from, searched), limit, steps.in(options.press_still));
    if (decline.faded > static_cast<std::size_t>(top - rates.begin())) break;
  }
  decline.faded = std::min(decline.faded, searched);
  return decline;
}

/// rate = z + g (still - t)^power before the stage stands still, z after it. Steps from the onset.
struct DeclineFit {
  double still = 0, power = 1, log_likelihood = 0;
  double z = 0, chi2 = 0;

  /// When the speed is `share` of that at the onset.
  double end(double share) const { return still * (1.0 - std::pow(share, 1.0 / power)); }
};

/// The sum of squared residuals over the expected variance.
double chi2_of(std::span<const double> events, std::span<const double> shape, double z, double g) {
  double chi2 = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const double rate = z + g * shape[i];
    chi2 += (events[i] - rate) * (events[i] - rate) / std::max(rate, 0.5);
  }
  return chi2;
}

/// Fits of all powers and ends to the steps from `first` on; the best is the last.
std::vector<DeclineFit> decline_fits(const Steps& steps, std::span<const double> events, std::size_t first,
                                     const Decline& decline) {
  const auto fade = static_cast<double>(decline.faded - first);
  std::vector<DeclineFit> fits;
  DeclineFit best{.still = static_cast<double>(decline.faded), .log_likelihood = -std::numeric_limits<double>::infinity()};
  std::vector<double> shape(events.size());
  for (double power = 0.05; power <= 3.2; power *= 1.2) {
    double z = std::max(steps.quiet, 0.05), g = decline.peak / std::pow(std::max(fade, 1.0), power);
    for (double still = std::max(2.0, fade - 15.0); still <= std::min(fade + 25.0, static_cast<double>(events.size()));
         still += 0.5) {
      for (std::size_t i = 0; i < shape.size(); ++i) {
        const double left = still - (static_cast<double>(i) + 0.5);
        shape[i] = left > 0 ? std::pow(left, power) : 0.0;
      }
      DeclineFit fit{.still = still + static_cast<double>(first), .power = power};
      fit.log_likelihood = best_mix(events, shape, z, g);
      if (fit.log_likelihood > best.log_likelihood) {
        fit.z = z;
        fit.chi2 = chi2_of(events, shape, z, g);
        best = fit;
      }
      fits.push_back(fit);
    }
  }
  fits.push_back(best);
  return fits;
}

}  // namespace

FoundTime press_end(const LitRate& lit, const alignment::UncertainTime& onset, const EndOptions& options) {
  const Steps steps = steps_from(lit, onset.at, 1ms);
  const std::vector<double> rates = alignment::moving_mean(steps.events, steps.in(5ms));
  const std::size_t searched = std::min(rates.size(), burst_steps(lit, steps) + steps.in(50ms));
  if (searched < 3) return unknown_end(lit, onset);
  const Decline decline = decline_of(steps, rates, searched, lit.dispersion, options);

  // The decline's last half, or from where it last has 0.6 of its peak.
  std::size_t first = decline.faded;
  while (first > 0 && rates[first - 1] < steps.quiet + 0.6 * decline.peak) --first;
  first = std::max(std::min(first, decline.faded - std::min(decline.faded, steps.in(12ms))), decline.faded / 2);
  const std::size_t last = std::min(steps.events.size(), decline.faded + steps.in(40ms));
  const std::span<const double> events(steps.events.data() + first, last - first);
  const std::vector<DeclineFit> fits = decline_fits(steps, events, first, decline);
  const DeclineFit& best = fits.back();

  // A marker that moves sideways fast and is touched late has its peak speed after the onset, and a lower one: 1 % of the peak is
  // 0.5 % to 1 % of the stage's speed at the onset.
  const double freedom = std::max(1.0, static_cast<double>(events.size()) - 4.0);
  const double dispersion = std::max({1.0, lit.dispersion, best.chi2 / freedom});
  const double at = best.end(0.8 * options.still_share);
  double low = at, high = at;
  for (const DeclineFit& fit : fits) {
    if (fit.log_likelihood < best.log_likelihood - half_chi2 * dispersion) continue;
    low = std::min(low, fit.end(options.still_share));
    high = std::max(high, fit.end(0.5 * options.still_share));
  }
  FoundTime end{.time = {.at = steps.time_of(at),
                         .low = before(steps.time_of(low), options.least_error),
                         .high = after(steps.time_of(high), options.least_error)},
                .doubt = {}};
  if (best.z - steps.quiet > 0.8 * options.still_share * decline.peak) {
    end.doubt = doubt("end-creep", "its tips creep on at about 1 % of their peak speed");
    end.time.high = std::max(end.time.high, lit.rate.begin_of(lit.burst_end));
  }
  if (decline.faded >= searched) end.doubt = doubt("end-no-rest", "it does not come to rest before the next motion");
  // A slow stage's last motion makes few events, and creep hides it: what is extrapolated falls short.
  constexpr double falls_short = 0.15;
  const microseconds open = between(end.time.at, end.time.high);
  end.time.high = after(end.time.high, microseconds{std::llround(falls_short * static_cast<double>(open.count()))});
  end_after(onset, lit.rate.bin, end.time);
  check_width(end, options);
  return end;
}

FoundTime slip_end(const LitRate& lit, const alignment::UncertainTime& onset, const EndOptions& options,
                   const std::optional<alignment::UncertainTime>& arm_stop) {
  const Steps steps = steps_from(lit, onset.at, 400us);
  const std::vector<double> rates = alignment::moving_mean(steps.events, steps.in(3ms));
  const std::size_t whole = std::min(rates.size(), burst_steps(lit, steps) + 1);
  if (whole < 3) return unknown_end(lit, onset);
  const double peak =
      std::max(1e-6, *std::max_element(rates.begin(), rates.begin() + static_cast<std::ptrdiff_t>(whole)) - steps.quiet);
  const double visible = std::max(options.still_share * peak, least_limit(steps, lit.dispersion, steps.in(3ms), 3.5));
  // The tips are seen to move until then; later motion is fainter, or not theirs.
  const std::size_t seen =
      std::max<std::size_t>(1, std::min(still_from(rates, 0, steps.quiet + visible, steps.in(options.slip_still)), rates.size()));
  const std::size_t from = seen - std::min(seen, steps.in(20ms));
  const double top =
      *std::max_element(rates.begin() + static_cast<std::ptrdiff_t>(from), rates.begin() + static_cast<std::ptrdiff_t>(seen)) -
      steps.quiet;
  std::size_t half = seen;
  while (half > from + 1 && rates[half - 1] < steps.quiet + 0.5 * top) --half;
  const double tau = static_cast<double>(seen - half) / std::log(std::max(2.0, 0.5 * top / visible));
  const auto at = [&](double steps_later, microseconds shift) {
    return after(steps.time_of(static_cast<double>(seen) + steps_later), shift);
  };
  FoundTime end{.time = {.at = at(4.0 * tau, 0us), .low = at(0.0, -9ms), .high = at(6.0 * tau, 20ms)}, .doubt = {}};
  // A long, weak tail may be the arm's ringing where it stops, which is no slip, or a surface that still runs past.
  std::size_t strong = seen;
  while (strong > 1 && rates[strong - 1] < steps.quiet + std::max(0.1 * peak, visible)) --strong;
  if (seen - strong > steps.in(60ms))
    end.time.low = std::min(end.time.low, before(steps.time_of(static_cast<double>(strong)), options.rung_out));
  if (arm_stop) {
    end.time.high = std::max(end.time.high, after(arm_stop->high, options.rung_out / 2));
    // Tips that are not seen to move for long may slide over a smooth face, or have no object left.
    const bool left_early = between(end.time.at, arm_stop->at) > options.longest_unseen;
    if (end.time.at < arm_stop->at && !left_early) end.time.at = arm_stop->at;
    const CameraTime rung_out = after(arm_stop->at, options.rung_out);
    if (end.time.at > after(arm_stop->high, options.rung_out)) {
      end.time.at = rung_out;
      end.time.low = std::min(end.time.low, before(arm_stop->low, options.stick_phase));
    }
    end.time.low = std::min(end.time.low, end.time.at);
  }
  if (seen >= rates.size()) end.doubt = doubt("end-unrecorded", "the recording ends before it does");
  end_after(onset, lit.rate.bin, end.time);
  check_width(end, options);
  return end;
}

}  // namespace tactile::labels
