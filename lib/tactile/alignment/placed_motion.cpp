#include "tactile/alignment/placed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tactile/alignment/lowest_point.hpp"
#include "tactile/core/duration_units.hpp"

namespace tactile::alignment {
namespace {

/// Time from the start of a lift until the arm has moved so far [s].
double time_of_travel(const MotionPhase& lift, double travel_m) {
  constexpr double step_s = 1e-3;
  const double lasts_s = in_s(lift.end - lift.start);
  double moved_m = 0, since_s = 0;
  while (moved_m < travel_m && since_s < lasts_s) {
    moved_m += step_s * lift.profile->commanded_m_s(since_s + 0.5 * step_s);
    since_s += step_s;
  }
  return since_s;
}

/// Weighted sums of counts r and speeds v.
struct Sums {
  double rv = 0, vv = 0, rr = 0;

  void add(double r, double v, double weight) {
    rv += weight * r * v;
    vv += weight * v * v;
    rr += weight * r * r;
  }
  double explained() const { return vv > 0 && rv > 0 ? rv * rv / vv : 0.0; }
  double unexplained() const { return vv > 0 ? rr - rv * rv / vv : rr; }  ///< by the best r = gain * v
};

double mean_of_five(const Milliseconds& ms, std::ptrdiff_t i) {
  double sum = 0;
  for (std::ptrdiff_t j = i - 2; j <= i + 2; ++j) sum += ms.counts[static_cast<std::size_t>(j)] - ms.quiet;
  return 0.2 * sum;
}

/// The first hill of the rate near a lift's start: where it begins, and its top. In milliseconds.
struct Hill {
  std::ptrdiff_t onset = 0, top = 0;
};

/// @return nothing if no activity begins in [from, to)
std::optional<Hill> first_hill(const Milliseconds& ms, std::ptrdiff_t from, std::ptrdiff_t to) {
  double most = 0;
  for (std::ptrdiff_t i = from; i < to; ++i) most = std::max(most, mean_of_five(ms, i));
  const double noise = std::sqrt(ms.dispersion * std::max(ms.quiet, 0.2) / 5.0);
  if (most < 8 * noise) return std::nullopt;
  Hill hill{.onset = 0, .top = from};
  while (mean_of_five(ms, hill.top) < 0.5 * most) ++hill.top;
  for (std::ptrdiff_t i = hill.top + 1; i < to && i <= hill.top + 8; ++i) {
    if (mean_of_five(ms, i) > mean_of_five(ms, hill.top)) hill.top = i;
  }
  const double foot = std::max(0.06 * mean_of_five(ms, hill.top), 4 * noise);
  hill.onset = hill.top;
  while (hill.onset > from && ms.counts[static_cast<std::size_t>(hill.onset)] - ms.quiet > foot) --hill.onset;
  return hill.onset == from ? std::nullopt : std::optional(hill);  // else it began before
}

/// The counts of a window of milliseconds, [first, last], against the speed of a motion that starts at `start_s`.
class SpeedMatch {
 public:
  SpeedMatch(const Milliseconds& ms, const MotionPhase& motion, double start_s, std::ptrdiff_t first, std::ptrdiff_t last)
      : profile_(*motion.profile), start_s_(start_s), first_(first) {
    for (std::ptrdiff_t i = first; i <= last; ++i) {
      counts_.push_back(ms.counts[static_cast<std::size_t>(i)] - ms.quiet);
      weights_.push_back(1.0 / std::max(1.0, mean_of_five(ms, i) + ms.quiet));
    }
  }

  double unexplained(double shift, bool rings) const {
    Sums sums;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const double since_s = 1e-3 * (static_cast<double>(first_) + static_cast<double>(i) + 0.5) - shift - start_s_;
      sums.add(counts_[i], rings ? profile_.speed_m_s(since_s) : profile_.commanded_m_s(since_s), weights_[i]);
    }
    return sums.unexplained();
  }

  /// The weighted sum of squares about the mean.
  double spread() const {
    double weights = 0, mean = 0, spread = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      weights += weights_[i];
      mean += weights_[i] * counts_[i];
    }
    mean /= weights;
    for (std::size_t i = 0; i < counts_.size(); ++i) spread += weights_[i] * (counts_[i] - mean) * (counts_[i] - mean);
    return spread;
  }

 private:
  const SpeedProfile& profile_;
  double start_s_;
  std::ptrdiff_t first_;
  std::vector<double> counts_, weights_;
};

/// The mean by the variances of a shift that an unknown slack gives, and of one that the rate gives. All lifts of a mount have
/// the slack, so that what it leaves open is common to them.
PlacedMotion combined(const PlacedMotion& by_slack, double shift_s, double sigma_s, double common_s) {
  const double slack_s = by_slack.common_s;
  const double share = sigma_s * sigma_s / (sigma_s * sigma_s + slack_s * slack_s);
  return {.shift_s = share * by_slack.shift_s + (1.0 - share) * shift_s,
          .sigma_s = (1.0 - share) * sigma_s,
          .common_s = std::hypot(share * slack_s, common_s)};
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

std::optional<PlacedMotion> place_shear(const Milliseconds& ms, const MotionPhase& lift, double start_s, double shift_s,
                                        double most_slack_m) {
  // Tips let go one after the other, and edges have a width: the gain may change by so much over the window.
  constexpr double gain_changes = 0.05, least_model_s = 0.8e-3;
  const double start_ms = 1e3 * (start_s + shift_s);
  if (!(std::abs(start_ms) < 1e9)) return std::nullopt;
  const auto from = static_cast<std::ptrdiff_t>(std::max(2.0, start_ms - 100));
  const auto to = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(ms.counts.size()) - 3, start_ms + 160));
  if (to - from < 60) return std::nullopt;
  const std::optional<Hill> hill = first_hill(ms, from, to);
  if (!hill) return std::nullopt;
  const auto [onset, top] = *hill;

  // If nothing else is known: between the greatest slack and none.
  const double longest_lag_s = time_of_travel(lift, most_slack_m);
  const double latest_s = 1e-3 * static_cast<double>(onset) + 0.001 - start_s;
  constexpr double onset_sigma_s = 1e-3;
  const PlacedMotion placed{
      .shift_s = latest_s - 0.5 * longest_lag_s, .sigma_s = onset_sigma_s, .common_s = longest_lag_s / std::sqrt(12.0)};

  // After the first milliseconds, in which an edge moves by less than its own width, and well before the top, where the first
  // tips let go.
  const std::ptrdiff_t first = onset + 3;
  const std::ptrdiff_t last = onset + std::max<std::ptrdiff_t>(std::lround(0.6 * static_cast<double>(top - onset)), 6);
  if (last > top - 1 || last >= to) return placed;
  const SpeedMatch match(ms, lift, start_s, first, last);
  const auto by_command = [&](double shift) { return match.unexplained(shift, false); };
  const auto with_ringing = [&](double shift) { return match.unexplained(shift, true); };
  const double reach_s = 0.5 * std::max(longest_lag_s, 0.045), spread = match.spread();
  const LowestPoint best = lowest_point(by_command, latest_s - reach_s, reach_s + 1e-3, 1e-3);
  if (!(best.curvature > 0) || !(spread > 0)) return placed;
  // Whether the tips follow the command or the ringing flange is not known.
  const double ringing_s =
      lift.profile->rings() ? 0.5 * std::abs(lowest_point(with_ringing, best.at, 0.006, 1e-3).at - best.at) : 0.0;
  const double dispersion = std::max({1.0, ms.dispersion, best.value / static_cast<double>(last - first)});
  // A short window gives an uncertain gradient, which counts the more the farther the start is.
  const double window_s = 1e-3 * static_cast<double>(last - first + 1);
  const double led_s = 1e-3 * 0.5 * static_cast<double>(first + last + 1) - start_s - best.at;
  const double model_s = std::max(least_model_s, gain_changes * led_s * led_s / window_s);
  // Edges that have a width and tips that follow late shift the start by a distance: a slow arm takes longer for it.
  constexpr double distance_off_m = 40e-6;
  const auto speed_at = [&](std::ptrdiff_t ms_at) {
    return lift.profile->commanded_m_s(1e-3 * static_cast<double>(ms_at) - start_s - best.at);
  };
  const double onset_speed_m_s = std::max(speed_at(onset), 0.25 * speed_at(last));  // the onset may precede a start placed late
  PlacedMotion by_rate = combined(placed, best.at, std::hypot(std::sqrt(2.0 * dispersion / best.curvature), model_s, ringing_s),
                                  std::min(distance_off_m / std::max(onset_speed_m_s, 1e-6), longest_lag_s));
  by_rate.likeness = std::clamp(1.0 - best.value / spread, 0.0, 1.0);
  return by_rate;
}

std::optional<PlacedMotion> place_ring_down(const Milliseconds& ms, const MotionPhase& lift, double start_s, double shift_s) {
  constexpr double from_stop_s = 0.012, longest_s = 0.25;  // by then the last tips that sprang back have come to rest
  constexpr double least_gain = 25.0;                      // twice the log-likelihood ratio: five standard deviations
  constexpr double model_s = 5e-3;  // a tip that rings by less than a pixel fires where it passes a threshold
  const SpeedProfile& profile = *lift.profile;
  if (!profile.rings()) return std::nullopt;
  const double stop_s = start_s + in_s(lift.end - lift.start) + shift_s;
  const double lasts_s = std::min(longest_s, 3.0 * profile.ringing.decay_s);
  if (!(std::abs(stop_s) < 1e6) || stop_s < 0) return std::nullopt;
  const auto first = static_cast<std::size_t>(1e3 * (stop_s + from_stop_s));
  const auto last = static_cast<std::size_t>(1e3 * (stop_s + lasts_s));
  if (last >= ms.counts.size() || last < first + 30) return std::nullopt;
  const auto cost = [&](double shift) {
    Sums sums;
    for (std::size_t i = first; i <= last; ++i) {
      const double since_s = 1e-3 * (static_cast<double>(i) + 0.5) - shift - start_s;
      sums.add(ms.counts[i] - ms.quiet, profile.speed_m_s(since_s), 1.0);
    }
    return -sums.explained() / (ms.dispersion * std::max(ms.quiet, 0.2));
  };
  const double reach_s = 0.2 / profile.ringing.hz;
  const LowestPoint best = lowest_point(cost, shift_s, reach_s, 1e-3);
  if (!(-best.value > least_gain) || !(best.curvature > 0) || std::abs(best.at - shift_s) > 0.9 * reach_s) return std::nullopt;
  return PlacedMotion{.shift_s = best.at, .sigma_s = std::hypot(std::sqrt(2.0 / best.curvature), model_s), .likeness = 0};
}

namespace {

/// The counts around the lowest point of a tap against its commanded speed.
class TapMatch {
 public:
  TapMatch(const Milliseconds& ms, const MotionPhase& tap, double start_s, std::ptrdiff_t from, std::ptrdiff_t to)
      : profile_(*tap.profile),
        turn_since_s_(in_s(*tap.turn - tap.start)),
        turn_s_(start_s + turn_since_s_),
        from_(from),
        turning_s_(0.12 * half_of(tap)),
        most_half_s_(0.6 * half_of(tap)) {
    const auto n = static_cast<std::size_t>(to - from);
    const auto count_at = [&](std::size_t i) { return ms.counts[static_cast<std::size_t>(from) + i]; };
    for (std::size_t i = 0; i < n; ++i) {
      double near = 0;
      for (std::size_t j = i >= 2 ? i - 2 : 0; j < std::min(n, i + 3); ++j) near += count_at(j);
      counts_.push_back(count_at(i) - ms.quiet);
      weights_.push_back(1.0 / std::max({1.0, ms.quiet, 0.2 * near}));
      all_ += weights_[i] * counts_[i] * counts_[i];
    }
  }

  static double half_of(const MotionPhase& tap) { return 0.5 * in_s(tap.end - tap.start); }

  /// How much of the activity is left unexplained, at the best length of contact, which `half_s` gets. Milliseconds are added
  /// outwards from the lowest point on either side. The first pixels of the motion out have just
  /// fired in the motion in. They need twice their threshold, and so have a gain of their own.
  double unexplained(double shift, double& half_s) const {
    std::array<Sums, 3> sides{};  // in, turning, out
    const double middle_ms = 1e3 * (turn_s_ + shift) - static_cast<double>(from_);
    auto before = static_cast<std::ptrdiff_t>(std::floor(middle_ms - 0.5)), after = before + 1;
    const auto take = [&](std::ptrdiff_t i) {
      if (i < 0 || i >= static_cast<std::ptrdiff_t>(counts_.size())) return;
      const double since_s = 1e-3 * (static_cast<double>(i) + 0.5 - middle_ms);
      const auto at = static_cast<std::size_t>(i);
      sides[since_s < 0            ? 0
            : since_s < turning_s_ ? 1
                                   : 2]
          .add(counts_[at], profile_.commanded_m_s(turn_since_s_ + since_s), weights_[at]);
    };
    double most = 0;
    for (double tried_s = 0.001; tried_s < most_half_s_; tried_s += 0.001) {
      take(before--);
      take(after++);
      if (tried_s < turning_s_ + 0.002) continue;
      const double explained = sides[0].explained() + sides[1].explained() + sides[2].explained();
      if (explained <= most) continue;
      most = explained;
      half_s = tried_s;
    }
    return all_ - most;
  }

  double likeness(double shift, double& half_s) const {
    const double left = unexplained(shift, half_s);
    return all_ > 0 ? std::clamp(1.0 - left / all_, 0.0, 1.0) : 0.0;
  }

  /// To a tenth of a millisecond by the motion in alone. Its rate decreases with the speed to zero at the lowest point, and
  /// stays there until the pixels respond again. `milliseconds` gets how many were used.
  LowestPoint by_motion_in(double shift_s, double half_s, std::size_t& milliseconds) const {
    const double lowest_ms = 1e3 * (turn_s_ + shift_s) - static_cast<double>(from_), n = static_cast<double>(counts_.size());
    const auto first = static_cast<std::size_t>(std::clamp(lowest_ms - 750 * half_s, 0.0, n));
    const auto last = static_cast<std::size_t>(std::clamp(lowest_ms + 500 * turning_s_, 0.0, n));
    milliseconds = last - first;
    const auto cost = [&](double shift) {
      Sums sums;
      for (std::size_t i = first; i < last; ++i) {
        const double t = 1e-3 * (static_cast<double>(from_) + static_cast<double>(i) + 0.5) - shift;
        sums.add(counts_[i], t < turn_s_ ? profile_.commanded_m_s(t - turn_s_ + turn_since_s_) : 0.0, weights_[i]);
      }
      return sums.unexplained();
    };
    return milliseconds < 8 ? LowestPoint{} : lowest_point(cost, shift_s, 0.008, 1e-3);
  }

 private:
  const SpeedProfile& profile_;
  double turn_since_s_, turn_s_;  ///< of the motion's start, and of the robot's clock
  std::ptrdiff_t from_;
  double turning_s_, most_half_s_;
  std::vector<double> counts_, weights_;
  double all_ = 0;
};

}  // namespace

std::optional<PlacedMotion> place_tap(const Milliseconds& ms, const MotionPhase& tap, double start_s, double shift_s) {
  constexpr double model_s = 1.0e-3;  // pixels that turn back need twice their threshold
  constexpr double reach_s = 0.1, least_likeness = 0.3;
  const double turn_ms = 1e3 * (start_s + in_s(*tap.turn - tap.start) + shift_s);
  if (!(std::abs(turn_ms) < 1e9)) return std::nullopt;
  const double around_ms = 1e3 * (reach_s + 0.6 * TapMatch::half_of(tap));
  const auto from = static_cast<std::ptrdiff_t>(std::max(0.0, turn_ms - around_ms));
  const auto to = static_cast<std::ptrdiff_t>(std::min(static_cast<double>(ms.counts.size()), turn_ms + around_ms));
  if (to - from < std::llround(2 * around_ms) - 4) return std::nullopt;  // it lies at the recording's end
  const TapMatch match(ms, tap, start_s, from, to);
  double half_s = 0;
  const LowestPoint rough = lowest_point([&](double shift) { return match.unexplained(shift, half_s); }, shift_s, reach_s, 2e-3);
  const double likeness = match.likeness(rough.at, half_s);
  if (likeness < least_likeness) return std::nullopt;
  std::size_t milliseconds = 0;
  const LowestPoint best = match.by_motion_in(rough.at, half_s, milliseconds);
  if (milliseconds < 8 || !(best.curvature > 0)) return std::nullopt;
  const double dispersion = std::max({1.0, ms.dispersion, best.value / static_cast<double>(milliseconds - 2)});
  return PlacedMotion{.shift_s = best.at,
                      .sigma_s = std::hypot(1.5 * std::sqrt(2.0 * dispersion / best.curvature), model_s),
                      .likeness = likeness};
}

}  // namespace tactile::alignment
