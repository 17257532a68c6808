#include "tactile/labels/placed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tactile/labels/lowest_point.hpp"

namespace tactile {
namespace {

/// From the start of a lift until the arm has gone so far [s].
double time_of_travel(const CommandedMotion& lift, double travel_m) {
  constexpr double step_s = 1e-3;
  double gone_m = 0, since_s = 0;
  while (gone_m < travel_m && lift.change_s[0] + since_s < lift.change_s[3]) {
    gone_m += step_s * std::abs(lift.told_m_s(lift.change_s[0] + since_s + 0.5 * step_s));
    since_s += step_s;
  }
  return since_s;
}

}  // namespace

Milliseconds milliseconds_of(const EventRate& rate, const QuietRate& quiet) {
  const std::int64_t bin_us = rate.bin.count();
  const double bins = 1e3 / static_cast<double>(bin_us);
  Milliseconds ms{
      .counts = std::vector<double>(static_cast<std::size_t>(static_cast<std::int64_t>(rate.counts.size()) * bin_us / 1'000)),
      .quiet = quiet.mean * bins,
      .dispersion = quiet.dispersion};
  for (std::size_t i = 0; i < rate.counts.size(); ++i) {
    const auto at = static_cast<std::size_t>(static_cast<std::int64_t>(i) * bin_us / 1'000);
    if (at < ms.counts.size()) ms.counts[at] += rate.counts[i];
  }
  return ms;
}

std::optional<PlacedMotion> place_shear(const Milliseconds& ms, const CommandedMotion& lift, double begin_s, double shift_s,
                                        double most_slack_m) {
  // Tips let go one after the other, and edges have a width: the gain may change by so much from the window's begin to its end.
  constexpr double gain_changes = 0.05, least_model_s = 0.8e-3;
  const double start_ms = 1e3 * (begin_s + lift.change_s[0] + shift_s);
  if (!(std::abs(start_ms) < 1e9)) return std::nullopt;
  const auto from = static_cast<std::ptrdiff_t>(std::max(2.0, start_ms - 100));
  const auto to = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(ms.counts.size()) - 3, start_ms + 160));
  if (to - from < 60) return std::nullopt;
  const auto count_at = [&](std::ptrdiff_t i) { return ms.counts[static_cast<std::size_t>(i)] - ms.quiet; };
  const auto smooth = [&](std::ptrdiff_t i) {
    double sum = 0;
    for (std::ptrdiff_t j = i - 2; j <= i + 2; ++j) sum += count_at(j);
    return 0.2 * sum;
  };
  double most = 0;
  for (std::ptrdiff_t i = from; i < to; ++i) most = std::max(most, smooth(i));
  const double noise = std::sqrt(ms.dispersion * std::max(ms.quiet, 0.2) / 5.0);
  if (most < 8 * noise) return std::nullopt;
  // The first hill that is half as high as the highest: up to its top, then down its near side.
  std::ptrdiff_t top = from;
  while (smooth(top) < 0.5 * most) ++top;
  for (std::ptrdiff_t i = top + 1; i < to && i <= top + 8; ++i) {
    if (smooth(i) > smooth(top)) top = i;
  }
  const double foot = std::max(0.06 * smooth(top), 4 * noise);
  std::ptrdiff_t onset = top;
  while (onset > from && count_at(onset) > foot) --onset;

  // Between the slack that there may be and none at all, if nothing else is known.
  const double longest_lag_s = time_of_travel(lift, most_slack_m);
  const double latest_s = 1e-3 * static_cast<double>(onset) + 0.001 - begin_s - lift.change_s[0];
  PlacedMotion placed;
  placed.shift_s = latest_s - 0.5 * longest_lag_s;
  placed.sigma_s = longest_lag_s / std::sqrt(12.0);
  if (onset == from) return std::nullopt;  // it was under way before

  // Behind the first milliseconds, in which an edge moves by less than its own width, and well before the top, where the first
  // tips let go.
  const std::ptrdiff_t first = onset + 3, last = onset + std::max<std::ptrdiff_t>(std::lround(0.6 * double(top - onset)), 6);
  if (last > top - 1 || last >= to) return placed;
  const auto weight = [&](std::ptrdiff_t i) { return 1.0 / std::max(1.0, smooth(i) + ms.quiet); };
  double weights = 0, mean = 0, spread = 0;
  for (std::ptrdiff_t i = first; i <= last; ++i) {
    weights += weight(i);
    mean += weight(i) * count_at(i);
  }
  mean /= weights;
  for (std::ptrdiff_t i = first; i <= last; ++i) spread += weight(i) * (count_at(i) - mean) * (count_at(i) - mean);
  const auto unlike = [&](double shift, bool rings) {
    double rv = 0, vv = 0, rr = 0;
    for (std::ptrdiff_t i = first; i <= last; ++i) {
      const double since_s = 1e-3 * (static_cast<double>(i) + 0.5) - shift - begin_s, r = count_at(i);
      const double v = std::abs(rings ? lift.speed_m_s(since_s) : lift.told_m_s(since_s));
      rv += weight(i) * r * v;
      vv += weight(i) * v * v;
      rr += weight(i) * r * r;
    }
    return vv > 0 ? rr - rv * rv / vv : rr;
  };
  const double reach_s = 0.5 * std::max(longest_lag_s, 0.045);
  const auto as_told = [&](double shift) { return unlike(shift, false); };
  const auto as_it_rings = [&](double shift) { return unlike(shift, true); };
  const LowestPoint best = lowest_point(as_told, latest_s - reach_s, reach_s + 1e-3, 1e-3);
  if (!(best.curvature > 0) || !(spread > 0)) return placed;
  // Whether the tips follow what the arm was told or how it rings at the flange is not known.
  const double ringing_s =
      lift.ringing_share > 0 ? 0.5 * std::abs(lowest_point(as_it_rings, best.at, 0.006, 1e-3).at - best.at) : 0.0;
  const double dispersion = std::max({1.0, ms.dispersion, best.value / static_cast<double>(last - first)});
  // A line that is led far down from a short window goes astray with its slope.
  const double window_s = 1e-3 * static_cast<double>(last - first + 1);
  const double led_s = 1e-3 * 0.5 * static_cast<double>(first + last + 1) - begin_s - lift.change_s[0] - best.at;
  const double model_s = std::max(least_model_s, gain_changes * led_s * led_s / window_s);
  // Edges that have a width and tips that follow late put the start off by a way, which takes the longer the slower the arm.
  constexpr double way_off_m = 40e-6;
  const double onset_speed_m_s = std::abs(lift.told_m_s(1e-3 * static_cast<double>(onset) - begin_s - best.at));
  placed.common_s = std::min(way_off_m / std::max(onset_speed_m_s, 1e-6), longest_lag_s);
  const double fit_s = std::hypot(std::sqrt(2.0 * dispersion / best.curvature), model_s, ringing_s);
  // Both together.
  const double w_fit = 1.0 / (fit_s * fit_s), w_slack = 1.0 / (placed.sigma_s * placed.sigma_s);
  placed.shift_s = (w_fit * best.at + w_slack * placed.shift_s) / (w_fit + w_slack);
  placed.sigma_s = 1.0 / std::sqrt(w_fit + w_slack);
  placed.likeness = std::clamp(1.0 - best.value / spread, 0.0, 1.0);
  return placed;
}

std::optional<PlacedMotion> place_ring_down(const Milliseconds& ms, const CommandedMotion& lift, double begin_s, double shift_s) {
  constexpr double from_stop_s = 0.012, longest_s = 0.25;  // by then the last tips that sprang back have come to rest
  constexpr double least_gain = 25.0;                      // twice the log-likelihood ratio: five standard deviations
  constexpr double model_s = 5e-3;  // a tip that rings by less than a pixel fires where it passes a threshold
  if (!(lift.ringing_share > 0)) return std::nullopt;
  const double stop_s = begin_s + lift.change_s[3] + shift_s, lasts_s = std::min(longest_s, 3.0 * lift.ringing_decay_s);
  if (!(std::abs(stop_s) < 1e6) || stop_s < 0) return std::nullopt;
  const auto first = static_cast<std::size_t>(1e3 * (stop_s + from_stop_s)),
             last = static_cast<std::size_t>(1e3 * (stop_s + lasts_s));
  if (last >= ms.counts.size() || last < first + 30) return std::nullopt;
  const auto explained = [&](double shift) {
    double rv = 0, vv = 0;
    for (std::size_t i = first; i <= last; ++i) {
      const double v = std::abs(lift.speed_m_s(1e-3 * (static_cast<double>(i) + 0.5) - shift - begin_s));
      rv += (ms.counts[i] - ms.quiet) * v;
      vv += v * v;
    }
    return rv > 0 ? rv * rv / (vv * ms.dispersion * std::max(ms.quiet, 0.2)) : 0.0;
  };
  const auto cost = [&](double shift) { return -explained(shift); };
  const double reach_s = 0.2 / lift.ringing_hz;
  const LowestPoint best = lowest_point(cost, shift_s, reach_s, 1e-3);
  if (!(-best.value > least_gain) || !(best.curvature > 0) || std::abs(best.at - shift_s) > 0.9 * reach_s) return std::nullopt;
  return PlacedMotion{.shift_s = best.at, .sigma_s = std::hypot(std::sqrt(2.0 / best.curvature), model_s), .likeness = 0};
}

std::optional<PlacedMotion> place_tap(const Milliseconds& ms, const CommandedMotion& tap, double begin_s, double shift_s) {
  constexpr double model_s = 1.0e-3;  // pixels that turn back need twice their threshold
  constexpr double reach_s = 0.1, least_likeness = 0.3;
  const double turn = begin_s + tap.turn_s(), half_tap_s = 0.5 * (tap.change_s[3] - tap.change_s[0]);
  const double turn_ms = 1e3 * (turn + shift_s);
  if (!(std::abs(turn_ms) < 1e9)) return std::nullopt;
  const double around_ms = 1e3 * (reach_s + 0.6 * half_tap_s);
  const auto from = static_cast<std::ptrdiff_t>(std::max(0.0, turn_ms - around_ms));
  const auto to = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(ms.counts.size()), turn_ms + around_ms));
  if (to - from < std::llround(2 * around_ms) - 4) return std::nullopt;  // it lies at the recording's end
  const auto n = static_cast<std::size_t>(to - from);
  std::vector<double> counts(n), weights(n);
  double all = 0;
  for (std::size_t i = 0; i < n; ++i) {
    counts[i] = ms.counts[static_cast<std::size_t>(from) + i] - ms.quiet;
    double near = 0;
    for (std::size_t j = i >= 2 ? i - 2 : 0; j < std::min(n, i + 3); ++j) near += ms.counts[static_cast<std::size_t>(from) + j];
    weights[i] = 1.0 / std::max({1.0, ms.quiet, 0.2 * near});
    all += weights[i] * counts[i] * counts[i];
  }
  // Outwards from the lowest point, bin by bin on either side: the first pixels to answer on the way back are those that had just
  // fired on the way in, and need twice their threshold, so that they have a gain of their own.
  double half_s = 0;
  const double turning_s = 0.12 * half_tap_s, least_half_s = turning_s + 0.002, most_half_s = 0.6 * half_tap_s;
  const auto cost = [&](double shift) {
    std::array<double, 3> rv{}, vv{};  // in, turning, out
    const double middle_ms = 1e3 * (turn + shift) - static_cast<double>(from);
    auto before = static_cast<std::ptrdiff_t>(std::floor(middle_ms - 0.5)), behind = before + 1;
    const auto take = [&](std::ptrdiff_t i) {
      if (i < 0 || i >= static_cast<std::ptrdiff_t>(n)) return;
      const double since_s = 1e-3 * (static_cast<double>(i) + 0.5 - middle_ms);
      const double v = std::abs(tap.told_m_s(tap.turn_s() + since_s));
      const std::size_t side = since_s < 0 ? 0 : since_s < turning_s ? 1 : 2;
      const auto at = static_cast<std::size_t>(i);
      rv[side] += weights[at] * counts[at] * v;
      vv[side] += weights[at] * v * v;
    };
    double most = 0;
    for (double tried_s = 0.001; tried_s < most_half_s; tried_s += 0.001) {
      take(before--);
      take(behind++);
      if (tried_s < least_half_s) continue;
      double explained = 0;
      for (std::size_t side = 0; side < 3; ++side)
        explained += vv[side] > 0 && rv[side] > 0 ? rv[side] * rv[side] / vv[side] : 0.0;
      if (explained > most) {
        most = explained;
        half_s = tried_s;
      }
    }
    return all - most;
  };
  const LowestPoint rough = lowest_point(cost, shift_s, reach_s, 2e-3);
  const double likeness = all > 0 ? std::clamp(1.0 - cost(rough.at) / all, 0.0, 1.0) : 0.0;
  if (likeness < least_likeness) return std::nullopt;

  // To the tenth of a millisecond by the way in alone: there the rate falls with the speed to nothing at the lowest point, and
  // stays there until the pixels answer again.
  const double lowest_ms = 1e3 * (turn + rough.at) - static_cast<double>(from);
  const auto first = static_cast<std::size_t>(std::clamp(lowest_ms - 750 * half_s, 0.0, static_cast<double>(n)));
  const auto last = static_cast<std::size_t>(std::clamp(lowest_ms + 500 * turning_s, 0.0, static_cast<double>(n)));
  if (last - first < 8) return std::nullopt;
  const auto way_in = [&](double shift) {
    double rv = 0, vv = 0, rr = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double t = 1e-3 * (static_cast<double>(from) + static_cast<double>(i) + 0.5);
      const double v = t - shift < turn ? std::abs(tap.told_m_s(t - shift - begin_s)) : 0.0;
      rv += weights[i] * counts[i] * v;
      vv += weights[i] * v * v;
      rr += weights[i] * counts[i] * counts[i];
    }
    return vv > 0 ? rr - rv * rv / vv : rr;
  };
  const LowestPoint best = lowest_point(way_in, rough.at, 0.008, 1e-3);
  if (!(best.curvature > 0)) return std::nullopt;
  const double dispersion = std::max({1.0, ms.dispersion, best.value / static_cast<double>(last - first - 2)});
  return PlacedMotion{.shift_s = best.at,
                      .sigma_s = std::hypot(1.5 * std::sqrt(2.0 * dispersion / best.curvature), model_s),
                      .likeness = likeness};
}

}  // namespace tactile
