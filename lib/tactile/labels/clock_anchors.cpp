#include "tactile/labels/clock_anchors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/labels/correlation.hpp"
#include "tactile/labels/imu_motion.hpp"
#include "tactile/robot/arm_motion.hpp"

namespace tactile {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

double seconds(microseconds d) { return 1e-6 * static_cast<double>(d.count()); }

/// Both clocks counted in seconds from the log's first row and the recording's first bin, so that doubles hold them; `shift`
/// below is camera seconds - robot seconds.
struct Origins {
  RobotTime robot{};
  CameraTime camera{};
  std::int64_t apart_us = 0;  ///< camera - robot

  double seconds_of(RobotTime t) const { return 1e-6 * static_cast<double>(saturating_subtract(us_of(t), us_of(robot))); }
  double seconds_of(CameraTime t) const { return 1e-6 * static_cast<double>(between(camera, t).count()); }
  ClockAnchor anchor(double robot_s, double shift_s, double sigma_s, AnchorKind kind, double bias_s) const {
    const std::int64_t since_us = std::llround(1e6 * robot_s);
    return {.clock_us = saturating_add(us_of(robot), since_us),
            .camera = after(camera, microseconds{saturating_add(since_us, std::llround(1e6 * shift_s))}),
            .sigma_us = 1e6 * sigma_s,
            .kind = kind,
            .bias_us = 1e6 * bias_s};
  }
};

/// The best and the second-best lag of a correlation whose values are all comparable.
struct Peak {
  std::size_t index = 0;
  double value = 0, second = 0;
  double offset = 0;  ///< of the parabola through the peak and its neighbours, -0.5 to 0.5

  double ratio() const { return second > 0 ? value / second : infinite; }
};

std::optional<Peak> highest_peak(std::span<const double> scores) {
  if (scores.empty()) return std::nullopt;
  Peak peak;
  peak.index = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  peak.value = scores[peak.index];
  if (!(peak.value > 0)) return std::nullopt;
  // All that falls away from the peak belongs to it.
  std::size_t low = peak.index, high = peak.index;
  while (low > 0 && scores[low - 1] <= scores[low]) --low;
  while (high + 1 < scores.size() && scores[high + 1] <= scores[high]) ++high;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (i < low || i > high) peak.second = std::max(peak.second, scores[i]);
  }
  if (peak.index > 0 && peak.index + 1 < scores.size()) {
    const double a = scores[peak.index - 1], b = scores[peak.index], c = scores[peak.index + 1];
    const double bend = a - 2 * b + c;
    if (bend < 0) peak.offset = std::clamp(0.5 * (a - c) / bend, -0.5, 0.5);
  }
  return peak;
}

/// The lags of a correlation that lie within what is known of the clocks.
struct Lags {
  double grid_s = 0;
  std::size_t zero = 0;  ///< index at which both begin together

  double shift_of(double index) const { return (index - static_cast<double>(zero)) * grid_s; }
};

void keep_within(std::vector<double>& scores, const Lags& lags, const std::optional<CoarseOffset>& coarse,
                 const Origins& origins) {
  if (!coarse) return;
  const double middle_s = 1e-6 * static_cast<double>(saturating_subtract(coarse->offset_us, origins.apart_us));
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (std::abs(lags.shift_of(static_cast<double>(i)) - middle_s) > seconds(coarse->within)) scores[i] = 0;
  }
}

/// Rows of the log between which the arm moves, half-open, with a rest on either side.
struct Stretch {
  std::size_t begin = 0, end = 0;
  double middle_s = 0;  ///< robot seconds
};

// ---------------------------------------------------------------------------------------------------------------- IMU

/// The felt velocity at any camera time within the samples, by straight lines; and whether there is a gap on the way.
class FeltVelocity {
 public:
  FeltVelocity(const FeltMotion& felt, const Origins& origins) : felt_(felt) {
    t_s_.reserve(felt.t.size());
    for (const CameraTime t : felt.t) t_s_.push_back(origins.seconds_of(t));
  }

  const std::vector<double>& t_s() const { return t_s_; }

  bool at(double t, std::array<double, 3>& velocity) const {
    const auto above = std::upper_bound(t_s_.begin(), t_s_.end(), t);
    if (above == t_s_.begin() || above == t_s_.end()) return false;
    const auto i = static_cast<std::size_t>(above - t_s_.begin());
    if (t_s_[i] - t_s_[i - 1] > 0.02) return false;
    const double share = (t - t_s_[i - 1]) / (t_s_[i] - t_s_[i - 1]);
    for (std::size_t k = 0; k < 3; ++k) velocity[k] = (1.0 - share) * felt_.velocity[i - 1][k] + share * felt_.velocity[i][k];
    return true;
  }

 private:
  const FeltMotion& felt_;
  std::vector<double> t_s_;
};

struct TimedSpeed {
  double t_s = 0, v = 0;
};

/// The sum of squares that v = a + b t + c . felt velocity leaves of v, as a share of what a + b t leaves; 1 where samples lack.
double unexplained(const std::vector<TimedSpeed>& rows, const FeltVelocity& felt, double shift_s) {
  constexpr std::size_t n = 5;  // 1, t, and three axes
  std::array<std::array<double, n + 1>, n + 1> sums{};
  const double middle_s = 0.5 * (rows.front().t_s + rows.back().t_s);
  std::array<double, 3> origin{};
  if (!felt.at(rows.front().t_s + shift_s, origin)) return 1.0;
  for (const TimedSpeed& row : rows) {
    std::array<double, 3> moved{};
    if (!felt.at(row.t_s + shift_s, moved)) return 1.0;
    const std::array<double, n + 1> terms{
        1.0, row.t_s - middle_s, moved[0] - origin[0], moved[1] - origin[1], moved[2] - origin[2], row.v};
    for (std::size_t i = 0; i <= n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) sums[i][j] += terms[i] * terms[j];
    }
  }
  // Cholesky's decomposition: the last pivot is what is left of v.
  double without_felt = 0;
  for (std::size_t i = 0; i <= n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double value = sums[i][j];
      for (std::size_t k = 0; k < j; ++k) value -= sums[i][k] * sums[j][k];
      if (j < i) {
        sums[i][j] = sums[j][j] > 0 ? value / sums[j][j] : 0.0;
        if (i == n && j == 1) {
          without_felt = sums[n][n];
          without_felt -= sums[n][0] * sums[n][0] + sums[n][1] * sums[n][1];
        }
      } else if (i == n) {
        return without_felt > 0 ? std::max(value, 0.0) / without_felt : 1.0;
      } else {
        sums[i][i] = value > 1e-12 * std::max(1e-12, sums[i][i]) ? std::sqrt(value) : 0.0;
      }
    }
  }
  return 1.0;
}

struct Minimum {
  double at = 0, value = 0, curvature = 0;
};

/// The lowest point of `cost` within `reach` of `middle`: by steps, then by thirds.
template <class Cost>
Minimum lowest(const Cost& cost, double middle, double reach, double step) {
  Minimum best{.at = middle, .value = infinite, .curvature = 0};
  for (double at = middle - reach; at <= middle + reach + 1e-9; at += step) {
    const double value = cost(at);
    if (value < best.value) best = {.at = at, .value = value, .curvature = 0};
  }
  double low = best.at - step, high = best.at + step;
  while (high - low > 1e-5) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (cost(a) < cost(b) ? high : low) = cost(a) < cost(b) ? b : a;
  }
  best.at = 0.5 * (low + high);
  best.value = cost(best.at);
  const double aside = 1e-3;
  best.curvature = (cost(best.at - aside) - 2 * best.value + cost(best.at + aside)) / (aside * aside);
  return best;
}

/// The felt acceleration on the grid, each point the mean since the one before it; what noise alone does is 0.
std::array<std::vector<double>, 3> felt_on_grid(const FeltMotion& felt, const FeltVelocity& velocity, double grid_s,
                                                double from_s, std::size_t points) {
  std::array<std::vector<double>, 3> grid;
  for (auto& axis : grid) axis.resize(points);
  const double samples_s =
      (velocity.t_s().back() - velocity.t_s().front()) / std::max<double>(1.0, static_cast<double>(felt.t.size() - 1));
  const double limit = 4.0 * felt.noise_m_s2 * std::sqrt(std::min(1.0, samples_s / grid_s));
  std::array<double, 3> last{}, now{};
  bool known = false;
  for (std::size_t i = 0; i <= points; ++i) {
    const bool is_known = velocity.at(from_s + grid_s * static_cast<double>(i), now);
    if (is_known && known) {
      double size = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        grid[k][i - 1] = (now[k] - last[k]) / grid_s;
        size += grid[k][i - 1] * grid[k][i - 1];
      }
      if (size < limit * limit) {
        for (std::size_t k = 0; k < 3; ++k) grid[k][i - 1] = 0;
      }
    }
    known = is_known;
    last = now;
  }
  return grid;
}

double energy_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

/// Keeps the stretch of `length` points with the most in it, and sets the others to 0: over many minutes a drift would smear the
/// match.
void keep_strongest(std::span<std::vector<double>* const> axes, std::size_t length) {
  const std::size_t n = axes.front()->size();
  if (n <= length) return;
  const auto power = [&](std::size_t i) {
    double sum = 0;
    for (const std::vector<double>* axis : axes) sum += (*axis)[i] * (*axis)[i];
    return sum;
  };
  double sum = 0, best = -1;
  std::size_t best_end = 0;
  for (std::size_t i = 0; i < n; ++i) {
    sum += power(i);
    if (i >= length) sum -= power(i - length);
    if (i + 1 >= length && sum > best) {
      best = sum;
      best_end = i + 1;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (i + length >= best_end && i < best_end) continue;
    for (std::vector<double>* axis : axes) (*axis)[i] = 0;
  }
}

/// The TCP's acceleration along each axis on the grid, what the noise of its speed does left out.
std::array<std::vector<double>, 3> arm_acceleration(const ArmMotion& motion) {
  std::vector<double> sizes;
  sizes.reserve(motion.acceleration.size());
  for (const auto& a : motion.acceleration) sizes.push_back(std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]));
  std::vector<double> sorted = sizes;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = 3.0 * *middle;
  std::array<std::vector<double>, 3> axes;
  for (std::size_t k = 0; k < 3; ++k) {
    axes[k].resize(sizes.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) axes[k][i] = sizes[i] > limit ? motion.acceleration[i][k] : 0.0;
  }
  return axes;
}

struct CoarseMatch {
  LagMatch match;
  double shift_s = 0;
};

constexpr double coarse_stretch_s = 100.0;

std::optional<CoarseMatch> match_imu(const ArmMotion& motion, const FeltMotion& felt, const FeltVelocity& velocity,
                                     const AnchorInputs& inputs, const AnchorOptions& options, const Origins& origins) {
  const double grid_s = seconds(options.grid), from_s = velocity.t_s().front();
  const double length_s = velocity.t_s().back() - from_s;
  constexpr double longest_s = 2 * 3600.0;
  if (!(length_s < longest_s)) return std::nullopt;
  const auto points = static_cast<std::size_t>(length_s / grid_s) + 1;
  std::array<std::vector<double>, 3> felt_axes = felt_on_grid(felt, velocity, grid_s, from_s, points);
  keep_strongest(std::array{&felt_axes[0], &felt_axes[1], &felt_axes[2]}, static_cast<std::size_t>(coarse_stretch_s / grid_s));
  const std::array<std::vector<double>, 3> arm_axes = arm_acceleration(motion);
  double felt_energy = 0, arm_energy = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    felt_energy += energy_of(felt_axes[k]);
    arm_energy += energy_of(arm_axes[k]);
  }
  if (!(felt_energy > 0) || !(arm_energy > 0)) return std::nullopt;
  // A turn of the sensor against the arm's base mixes the axes; the sum of all squares does not change with it.
  std::vector<double> scores;
  for (const auto& arm : arm_axes) {
    if (energy_of(arm) < 1e-3 * arm_energy) continue;
    for (const auto& axis : felt_axes) {
      if (energy_of(axis) < 1e-3 * felt_energy) continue;
      const std::vector<double> found = correlations(arm, axis);
      scores.resize(found.size());
      for (std::size_t i = 0; i < found.size(); ++i) scores[i] += found[i] * found[i];
    }
  }
  for (double& score : scores) score = std::sqrt(score / (felt_energy * arm_energy));
  const Lags lags{.grid_s = grid_s, .zero = arm_axes.front().size() - 1};
  // Grid point i of either covers the time from it to the next.
  const double begins_apart_s = from_s;
  if (inputs.coarse) {
    Origins shifted = origins;
    shifted.apart_us = saturating_add(origins.apart_us, std::llround(1e6 * begins_apart_s));
    keep_within(scores, lags, inputs.coarse, shifted);
  }
  const std::optional<Peak> peak = highest_peak(scores);
  if (!peak) return std::nullopt;
  const double shift_s = begins_apart_s + lags.shift_of(static_cast<double>(peak->index) + peak->offset);
  return CoarseMatch{.match = {.offset_us = saturating_add(origins.apart_us, std::llround(1e6 * shift_s)),
                               .likeness = peak->value,
                               .ratio = peak->ratio()},
                     .shift_s = shift_s};
}

/// Stretches of motion between rests, none longer than ten seconds.
std::vector<Stretch> stretches_of(const RobotLog& log, const Origins& origins) {
  constexpr double longest_s = 10.0, before_s = 0.08, behind_s = 0.15, merged_s = 0.25, longest_gap_s = 0.1;
  const std::vector<RobotState>& states = log.states;
  std::vector<double> speeds;
  for (const RobotState& state : states) speeds.push_back(std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]));
  std::vector<double> sorted = speeds;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = std::max(0.004, 4.2 * *middle);
  const auto t = [&](std::size_t i) { return origins.seconds_of(states[i].t); };
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (speeds[i] < limit) continue;
    const bool goes_on =
        !stretches.empty() && t(i) - t(stretches.back().end - 1) < merged_s && t(i) - t(stretches.back().begin) < longest_s;
    if (goes_on) {
      stretches.back().end = i + 1;
    } else {
      stretches.push_back({.begin = i, .end = i + 1, .middle_s = 0});
    }
  }
  std::erase_if(stretches, [&](Stretch& s) {
    if (t(s.end - 1) - t(s.begin) < 0.03) return true;
    const double from = t(s.begin) - before_s, to = t(s.end - 1) + behind_s;
    s.middle_s = 0.5 * (from + to);
    while (s.begin > 0 && t(s.begin - 1) >= from) --s.begin;
    while (s.end < states.size() && t(s.end) <= to) ++s.end;
    for (std::size_t i = s.begin + 1; i < s.end; ++i) {
      if (t(i) - t(i - 1) > longest_gap_s) return true;
    }
    return s.end - s.begin < 12;
  });
  return stretches;
}

void add_imu_anchors(FoundAnchors& found, const AnchorInputs& inputs, const AnchorOptions& options, const Origins& origins,
                     const ArmMotion& motion) {
  const FeltMotion felt = felt_motion(inputs.imu);
  if (felt.t.size() < 50) return;
  const FeltVelocity velocity(felt, origins);
  const std::optional<CoarseMatch> coarse = match_imu(motion, felt, velocity, inputs, options, origins);
  if (!coarse) {
    found.doubts.push_back("the camera's inertial sensor felt no motion, or the arm made none");
    return;
  }
  found.imu = coarse->match;
  if (coarse->match.likeness < options.least_likeness) {
    found.doubts.push_back(
        fmt::format("the arm's acceleration is not what the camera's inertial sensor felt: likeness {:.2f}, expected at "
                    "least {:.2f}",
                    coarse->match.likeness, options.least_likeness));
    return;
  }
  if (coarse->match.ratio < options.ambiguous_below) {
    found.doubts.push_back(fmt::format(
        "where the arm's acceleration lies on the felt one is ambiguous: the best match is only {:.2f} times as good as the "
        "second, expected {:.2f}",
        coarse->match.ratio, options.ambiguous_below));
    return;
  }

  // From the stretch nearest to the recording's middle outwards: a drift moves the later ones away.
  std::vector<Stretch> stretches = stretches_of(inputs.robot, origins);
  const double middle_s = 0.5 * (velocity.t_s().front() + velocity.t_s().back()) - coarse->shift_s;
  std::sort(stretches.begin(), stretches.end(), [&](const Stretch& a, const Stretch& b) {
    return std::abs(a.middle_s - middle_s) < std::abs(b.middle_s - middle_s);
  });
  constexpr double widest_drift = 200e-6, reach_s = 0.012, most_unexplained = 0.25;
  constexpr double floor_s = 200e-6, common_s = 120e-6;  // a sample is stamped up to a quarter of a millisecond late
  std::vector<std::pair<double, double>> known;          // robot seconds and shift
  for (const Stretch& stretch : stretches) {
    double expected = coarse->shift_s, distance = std::abs(stretch.middle_s - middle_s);
    for (const auto& [at_s, shift_s] : known) {
      if (std::abs(stretch.middle_s - at_s) <= distance) {
        distance = std::abs(stretch.middle_s - at_s);
        expected = shift_s;
      }
    }
    std::vector<TimedSpeed> rows;
    std::array<double, 3> direction{};
    double fastest = 0;
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const auto& v = inputs.robot.states[i].tcp_speed;
      const double speed = std::hypot(v[0], v[1], v[2]);
      if (speed > fastest) {
        fastest = speed;
        direction = {v[0] / speed, v[1] / speed, v[2] / speed};
      }
    }
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const RobotState& state = inputs.robot.states[i];
      rows.push_back({origins.seconds_of(state.t),
                      direction[0] * state.tcp_speed[0] + direction[1] * state.tcp_speed[1] + direction[2] * state.tcp_speed[2]});
    }
    const auto cost = [&](double shift_s) { return unexplained(rows, velocity, shift_s); };
    const Minimum best = lowest(cost, expected, reach_s + widest_drift * distance, 1e-3);
    if (!(best.value < most_unexplained) || !(best.curvature > 0)) continue;
    // The least squares' own deviation, doubled: what is left is the integral of noise, which wanders.
    const double sigma_s =
        std::hypot(floor_s, 2.0 * std::sqrt(2.0 * best.value / static_cast<double>(rows.size() - 6) / best.curvature));
    if (sigma_s > 0.005) continue;
    known.emplace_back(stretch.middle_s, best.at);
    found.anchors.push_back(origins.anchor(stretch.middle_s, best.at, sigma_s, AnchorKind::imu, common_s));
  }
  if (known.empty())
    found.doubts.push_back("no stretch of the arm's motion lies whole within what the camera's inertial sensor felt");
}

}  // namespace

FoundAnchors clock_anchors(const AnchorInputs& inputs, const AnchorOptions& options) {
  FoundAnchors found;
  if (inputs.robot.states.size() < 2 || inputs.rate.counts.empty()) {
    found.doubts.push_back("the robot log or the recording is empty");
    return found;
  }
  Origins origins{.robot = inputs.robot.states.front().t, .camera = inputs.rate.begin, .apart_us = 0};
  if (__builtin_sub_overflow(us_of(origins.camera), us_of(origins.robot), &origins.apart_us)) {
    found.doubts.push_back("the two clocks lie further apart than 64 bits of microseconds");
    return found;
  }
  const std::optional<ArmMotion> motion = arm_motion(inputs.robot, {.step = options.grid});
  if (!motion) {
    found.doubts.push_back("the robot log is too short, or too long, to be laid over the recording");
    return found;
  }
  if (!inputs.imu.empty()) add_imu_anchors(found, inputs, options, origins, *motion);
  return found;
}

}  // namespace tactile
