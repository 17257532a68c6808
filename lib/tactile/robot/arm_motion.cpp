#include "tactile/robot/arm_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/robot/least_squares.hpp"
#include "tactile/robot/main_direction.hpp"

namespace tactile {
namespace {

using Vector3 = std::array<double, 3>;

constexpr microseconds longest_gap = 100ms;

Vector3 velocity_of(const RobotState& state) { return {state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]}; }
double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length_of(const Vector3& v) { return std::sqrt(dot(v, v)); }

microseconds apart(RobotTime a, RobotTime b) { return microseconds{saturating_subtract(us_of(b), us_of(a))}; }

/// Five standard deviations of a resting arm, which is how it mostly is, and at least 4 mm/s.
double rest_limit(const std::vector<RobotState>& states) {
  std::vector<double> speeds;
  speeds.reserve(states.size());
  for (const RobotState& state : states) speeds.push_back(length_of(velocity_of(state)));
  // The magnitude of three noisy components has a median of 1.54 of their standard deviations.
  return std::max(0.004, upper_median(speeds) * (1.54 + 5.0) / 1.54);
}

/// The direction in which most of the motion goes; in the first half it is positive.
Vector3 direction_of(std::span<const RobotState> rows) {
  std::vector<Vector3> velocities;
  for (const RobotState& row : rows) velocities.push_back(velocity_of(row));
  Vector3 axis = main_direction(velocities).axis;
  double first_half = 0;
  for (const RobotState& row : rows.first((rows.size() + 1) / 2)) first_half += dot(axis, velocity_of(row));
  if (first_half < 0) {
    for (double& value : axis) value = -value;
  }
  return axis;
}

struct Sample {
  double t_s = 0, v = 0;
};

// What is fitted: three changes of the acceleration (the fourth undoes them), four times, and the ringing.
constexpr std::size_t time_at_0 = 3, share_at = 7, omega_at = 8, decay_at = 9, parameter_count = 10;
using Parameters = std::span<const double>;

std::array<double, 4> changes_of(Parameters p) { return {p[0], p[1], p[2], -p[0] - p[1] - p[2]}; }

double modelled(Parameters p, double t_s) {
  const std::array<double, 4> changes = changes_of(p);
  double v = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double since = t_s - p[time_at_0 + k];
    if (since <= 0) continue;
    v += changes[k] * since;
    if (p[share_at] != 0)
      v -= changes[k] * p[share_at] / p[omega_at] * std::exp(-p[decay_at] * since) * std::sin(p[omega_at] * since);
  }
  return v;
}

double misfit(Parameters p, std::span<const Sample> samples) {
  double sum = 0;
  for (const Sample& sample : samples) sum += (sample.v - modelled(p, sample.t_s)) * (sample.v - modelled(p, sample.t_s));
  return sum;
}

bool is_possible(Parameters p) {
  constexpr double least_apart_s = 1e-4;
  for (std::size_t k = 1; k < 4; ++k) {
    if (p[time_at_0 + k] < p[time_at_0 + k - 1] + least_apart_s) return false;
  }
  return p[share_at] >= 0 && p[share_at] <= 1.0 && p[omega_at] >= 2 * std::numbers::pi * 6 &&
         p[omega_at] <= 2 * std::numbers::pi * 50 && p[decay_at] >= 2 && p[decay_at] <= 100;
}

struct Fit {
  std::vector<double> p;
  double misfit = std::numeric_limits<double>::infinity();
  double shift_variance = 0;  ///< of the whole motion's place in time, per variance of the noise
};

/// The best fit that `start` leads to; without ringing, what it says of that is held.
Fit improved(std::vector<double> start, std::span<const Sample> samples, bool with_ringing) {
  LeastSquares problem{.residuals =
                           [samples](Parameters p, std::vector<double>& residuals) {
                             residuals.clear();
                             for (const Sample& sample : samples) residuals.push_back(modelled(p, sample.t_s) - sample.v);
                             return is_possible(p);
                           },
                       .steps = {1e-4, 1e-4, 1e-4, 1e-5, 1e-5, 1e-5, 1e-5, 1e-4, 1e-3, 1e-3}};
  if (!with_ringing) std::fill(problem.steps.begin() + share_at, problem.steps.end(), 0.0);
  Fit fit{.p = std::move(start)};
  fit.misfit = descend(problem, fit.p, 25);
  double speeding = 0;  // a shift of all changes together is seen where the speed changes
  for (const Sample& sample : samples) {
    const double slope = (modelled(fit.p, sample.t_s + 1e-4) - modelled(fit.p, sample.t_s - 1e-4)) / 2e-4;
    speeding += slope * slope;
  }
  fit.shift_variance = speeding > 0 ? 1.0 / speeding : std::numeric_limits<double>::infinity();
  return fit;
}

/// Where the speed is a share of its peak, first from the left (or from the right), by a straight line between two samples.
double crossing(std::span<const Sample> samples, double value, bool from_left) {
  const std::size_t n = samples.size();
  for (std::size_t i = 1; i < n; ++i) {
    const Sample& outer = from_left ? samples[i - 1] : samples[n - i];
    const Sample& inner = from_left ? samples[i] : samples[n - 1 - i];
    if (std::abs(outer.v) < value && std::abs(inner.v) >= value)
      return outer.t_s + (inner.t_s - outer.t_s) * (value - std::abs(outer.v)) / (std::abs(inner.v) - std::abs(outer.v));
  }
  return from_left ? samples.front().t_s : samples.back().t_s;
}

std::optional<CommandedMotion> fitted(std::span<const RobotState> rows, CommandedMotion::Kind kind) {
  CommandedMotion motion{.kind = kind, .begin = rows.front().t, .direction = direction_of(rows)};
  std::vector<Sample> samples;
  double peak = 0;
  for (const RobotState& row : rows) {
    samples.push_back({1e-6 * static_cast<double>(apart(motion.begin, row.t).count()), dot(motion.direction, velocity_of(row))});
    peak = std::max(peak, std::abs(samples.back().v));
  }
  // Two heights of each outer flank give its line.
  const double rise_low = crossing(samples, 0.2 * peak, true), rise_high = crossing(samples, 0.7 * peak, true);
  const double fall_low = crossing(samples, 0.2 * peak, false), fall_high = crossing(samples, 0.7 * peak, false);
  const double rise_s = std::max(0.004, (rise_high - rise_low) / 0.5), fall_s = std::max(0.004, (fall_low - fall_high) / 0.5);
  const double start_s = rise_low - 0.2 * rise_s, end_s = fall_low + 0.2 * fall_s;
  const double w = 2 * std::numbers::pi * 20, d = 12;
  std::vector<double> p;
  if (kind == CommandedMotion::Kind::one_way) {
    const double up = std::min(start_s + rise_s, 0.5 * (start_s + end_s) - 1e-3), down = std::max(end_s - fall_s, up + 2e-3);
    p = {peak / (up - start_s), -peak / (up - start_s), -peak / (end_s - down), start_s, up, down, end_s, 0, w, d};
  } else {
    const double quarter = 0.25 * (end_s - start_s), a = peak / quarter;
    p = {a, -2 * a, 2 * a, start_s, start_s + quarter, start_s + 3 * quarter, end_s, 0, w, d};
  }
  if (!(end_s - start_s > 0.01) || !is_possible(p)) return std::nullopt;

  Fit best = improved(p, samples, false);
  // The ringing: from the likeliest of some frequencies on.
  Fit ringing{.p = best.p};
  std::vector<double> tried = best.p;
  for (double hz = 9; hz < 40; hz *= 1.18) {
    for (const double share : {0.15, 0.35}) {
      tried[share_at] = share;
      tried[omega_at] = 2 * std::numbers::pi * hz;
      const double found = misfit(tried, samples);
      if (found < ringing.misfit) ringing = {.p = tried, .misfit = found, .shift_variance = 0};
    }
  }
  ringing = improved(ringing.p, samples, true);
  // Three more parameters explain some of the noise by themselves.
  const double rows_n = static_cast<double>(samples.size());
  if (ringing.misfit < best.misfit * (1.0 - 12.0 / rows_n)) best = ringing;

  motion.misfit_m_s = std::sqrt(best.misfit / std::max(1.0, rows_n - static_cast<double>(parameter_count)));
  if (!(motion.misfit_m_s < 0.1 * peak)) return std::nullopt;
  motion.change_m_s2 = changes_of(best.p);
  for (std::size_t k = 0; k < 4; ++k) motion.change_s[k] = best.p[time_at_0 + k];
  motion.ringing_share = best.p[share_at];
  motion.ringing_hz = best.p[omega_at] / (2 * std::numbers::pi);
  motion.ringing_decay_s = 1.0 / best.p[decay_at];
  // What the model leaves is no white noise: four rows of it are taken for one.
  motion.sigma_s = 2.0 * motion.misfit_m_s * std::sqrt(best.shift_variance);
  return motion;
}

}  // namespace

std::optional<ArmMotion> arm_motion(const RobotLog& log, const ArmMotionOptions& options) {
  const std::vector<RobotState>& states = log.states;
  if (states.size() < 2) return std::nullopt;
  const std::int64_t points = apart(states.front().t, states.back().t) / options.step + 1;
  if (points < 2 || static_cast<std::uint64_t>(points) > options.most_points) return std::nullopt;
  ArmMotion motion{.begin = states.front().t, .step = options.step, .velocity = {}, .acceleration = {}, .known = {}};
  const auto n = static_cast<std::size_t>(points);
  motion.velocity.resize(n);
  motion.acceleration.resize(n);
  motion.known.resize(n);
  std::size_t row = 0, gap = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const RobotTime t = motion.time_of(i);
    while (row + 2 < states.size() && states[row + 1].t <= t) ++row;
    const RobotState &a = states[row], &b = states[row + 1];
    while (gap < log.gaps.size() && log.gaps[gap].first_after <= a.t) ++gap;
    const bool in_gap = gap < log.gaps.size() && log.gaps[gap].last_before <= a.t && t > a.t;
    if (b.t - a.t > options.longest_gap || in_gap) continue;
    motion.known[i] = true;
    const double share = static_cast<double>((t - a.t).count()) / static_cast<double>((b.t - a.t).count());
    for (std::size_t k = 0; k < 3; ++k) motion.velocity[i][k] = (1.0 - share) * a.tcp_speed[k] + share * b.tcp_speed[k];
  }
  const double step_s = 1e-6 * static_cast<double>(options.step.count());
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!motion.known[i] || !motion.known[i + 1]) continue;
    for (std::size_t k = 0; k < 3; ++k) motion.acceleration[i][k] = (motion.velocity[i + 1][k] - motion.velocity[i][k]) / step_s;
  }
  return motion;
}

double CommandedMotion::told_m_s(double since_s) const {
  double v = 0;
  if (since_s >= change_s.back()) return v;
  for (std::size_t k = 0; k < 4; ++k) v += change_m_s2[k] * std::max(0.0, since_s - change_s[k]);
  return v;
}

double CommandedMotion::speed_m_s(double since_s) const {
  double v = told_m_s(since_s);
  if (ringing_share == 0) return v;
  const double w = 2 * std::numbers::pi * ringing_hz;
  for (std::size_t k = 0; k < 4; ++k) {
    const double since = since_s - change_s[k];
    if (since > 0) v -= change_m_s2[k] * ringing_share / w * std::exp(-since / ringing_decay_s) * std::sin(w * since);
  }
  return v;
}

double CommandedMotion::turn_s() const {
  for (std::size_t k = 1; k < 4; ++k) {
    const double before = told_m_s(change_s[k - 1]), at = told_m_s(change_s[k] - 1e-9);
    if (before > 0 && at <= 0) return change_s[k - 1] + (change_s[k] - change_s[k - 1]) * before / (before - at);
  }
  return 0.5 * (change_s.front() + change_s.back());
}

std::vector<CommandedMotion> commanded_motions(const RobotLog& log) {
  constexpr microseconds shortest = 60ms, merged = 60ms, rest_before = 60ms, rest_after = 200ms;
  const std::vector<RobotState>& states = log.states;
  if (states.size() < 8) return {};
  const double limit = rest_limit(states);

  struct Stretch {
    std::size_t begin = 0, end = 0;  // rows, half-open
  };
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < states.size();) {
    if (length_of(velocity_of(states[i])) < limit) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < states.size() && length_of(velocity_of(states[i])) >= limit) ++i;
    if (!stretches.empty() && apart(states[stretches.back().end - 1].t, states[begin].t) < merged) {
      stretches.back().end = i;
    } else {
      stretches.push_back({begin, i});
    }
  }

  std::vector<CommandedMotion> motions;
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    const Stretch& stretch = stretches[s];
    if (apart(states[stretch.begin].t, states[stretch.end - 1].t) < shortest) continue;
    // The rest on either side belongs to the fit: before it the arm stands still, behind it it rings.
    std::size_t begin = stretch.begin, end = stretch.end;
    const std::size_t least = s > 0 ? stretches[s - 1].end : 0;
    const std::size_t most = s + 1 < stretches.size() ? stretches[s + 1].begin : states.size();
    while (begin > least && apart(states[begin - 1].t, states[stretch.begin].t) <= rest_before) --begin;
    while (end < most && apart(states[stretch.end - 1].t, states[end].t) <= rest_after) ++end;
    if (begin == stretch.begin || end == stretch.end) continue;  // it was under way when the log began, or ended
    bool whole = true;
    for (std::size_t i = begin + 1; i < end; ++i) whole = whole && apart(states[i - 1].t, states[i].t) <= longest_gap;
    for (const RobotGap& gap : log.gaps)
      whole = whole && (gap.first_after <= states[begin].t || gap.last_before >= states[end - 1].t);
    if (!whole || end - begin < 12) continue;

    const std::span<const RobotState> rows(states.data() + begin, end - begin);
    const Vector3 direction = direction_of(rows);
    double way = 0, net = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const double step = 0.5e-6 * static_cast<double>((rows[i].t - rows[i - 1].t).count()) *
                          (dot(direction, velocity_of(rows[i])) + dot(direction, velocity_of(rows[i - 1])));
      way += std::abs(step);
      net += step;
    }
    const double share = std::abs(net) / std::max(way, 1e-12);
    if (share > 0.3 && share < 0.7) continue;
    if (const auto motion = fitted(rows, share >= 0.7 ? CommandedMotion::Kind::one_way : CommandedMotion::Kind::there_and_back))
      motions.push_back(*motion);
  }
  return motions;
}

}  // namespace tactile
