#include "tactile/alignment/imu_anchors.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tactile/alignment/correlation.hpp"
#include "tactile/alignment/imu_motion.hpp"
#include "tactile/alignment/lag_search.hpp"
#include "tactile/alignment/lowest_point.hpp"
#include "tactile/alignment/moving_mean.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

using Axes = std::array<std::vector<double>, 3>;

/// The IMU's velocity at any camera time within its samples, by straight lines.
class ImuVelocity {
 public:
  ImuVelocity(const ImuMotion& imu, const ClockOrigins& origins) : imu_(imu) {
    t_s_.reserve(imu.t.size());
    for (const CameraTime t : imu.t) t_s_.push_back(origins.seconds_of(t));
  }

  double begin_s() const { return t_s_.front(); }
  double end_s() const { return t_s_.back(); }
  double usual_step_s() const { return (end_s() - begin_s()) / std::max<double>(1.0, static_cast<double>(t_s_.size() - 1)); }

  /// Nothing outside the samples and within a gap.
  std::optional<Vector3> at(double t) const {
    constexpr double longest_gap_s = 0.02;
    const auto above = std::upper_bound(t_s_.begin(), t_s_.end(), t);
    if (above == t_s_.begin() || above == t_s_.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(above - t_s_.begin());
    if (t_s_[i] - t_s_[i - 1] > longest_gap_s) return std::nullopt;
    const double share = (t - t_s_[i - 1]) / (t_s_[i] - t_s_[i - 1]);
    Vector3 velocity{};
    for (std::size_t k = 0; k < 3; ++k) velocity[k] = (1.0 - share) * imu_.velocity[i - 1][k] + share * imu_.velocity[i][k];
    return velocity;
  }

 private:
  const ImuMotion& imu_;
  std::vector<double> t_s_;
};

/// Means over this many points of the grid keep the arm's acceleration and lower the noise: a quarter of its shortest ramp.
std::size_t smoothed_points(const AnchorSearch& search) {
  constexpr double share = 0.25, longest_s = 0.1;
  double ramp_s = infinite;
  for (const MotionPhase& motion : search.inputs.motions) {
    if (motion.profile && motion.is_whole()) ramp_s = std::min(ramp_s, motion.profile->knots_s[1] - motion.profile->knots_s[0]);
  }
  if (ramp_s == infinite) return 1;
  return static_cast<std::size_t>(std::max(1.0, std::min(share * ramp_s, longest_s) / search.grid_s()));
}

/// Smooths the axes, and sets to 0 where the acceleration is below the limit that `limit_of` gives for their sizes.
template <class LimitOf>
void keep_clear(Axes& axes, std::size_t smoothed, LimitOf&& limit_of) {
  for (std::vector<double>& axis : axes) axis = moving_mean(axis, smoothed);
  std::vector<double> sizes(axes[0].size());
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = length_of({axes[0][i], axes[1][i], axes[2][i]});
  const double limit = limit_of(sizes);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    for (std::vector<double>& axis : axes) axis[i] = sizes[i] > limit ? axis[i] : 0.0;
  }
}

/// The IMU's acceleration on the grid, each point the mean since the one before it; 0 where it could be noise.
Axes imu_acceleration(const ImuMotion& imu, const ImuVelocity& velocity, double grid_s, std::size_t points,
                      std::size_t smoothed) {
  Axes grid;
  for (auto& axis : grid) axis.resize(points);
  std::optional<Vector3> last;
  for (std::size_t i = 0; i <= points; ++i) {
    const std::optional<Vector3> now = velocity.at(velocity.begin_s() + grid_s * static_cast<double>(i));
    for (std::size_t k = 0; k < 3 && now && last; ++k) grid[k][i - 1] = ((*now)[k] - (*last)[k]) / grid_s;
    last = now;
  }
  const double averaged_s = grid_s * static_cast<double>(smoothed);
  const double noise = imu.noise_m_s2 * std::sqrt(std::min(1.0, velocity.usual_step_s() / averaged_s));
  keep_clear(grid, smoothed, [&](const std::vector<double>&) { return 4.0 * noise; });
  return grid;
}

/// The TCP's acceleration along each axis on the grid; 0 where it could be noise.
Axes arm_acceleration(const ArmMotion& motion, std::size_t smoothed) {
  Axes axes;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const Vector3& a : motion.acceleration) axes[k].push_back(a[k]);
  }
  keep_clear(axes, smoothed, [](std::vector<double> sizes) { return 3.0 * median(sizes); });
  return axes;
}

double energy_of_all(const Axes& axes) { return energy_of(axes[0]) + energy_of(axes[1]) + energy_of(axes[2]); }

std::optional<CoarseMatch> match_imu(const AnchorSearch& search, const ArmMotion& motion, const ImuMotion& imu,
                                     const ImuVelocity& velocity) {
  constexpr double longest_s = 2 * 3600.0, least_share = 1e-3;
  const double grid_s = search.grid_s(), length_s = velocity.end_s() - velocity.begin_s();
  if (!(length_s < longest_s)) return std::nullopt;
  const std::size_t smoothed = smoothed_points(search);
  Axes imu_axes = imu_acceleration(imu, velocity, grid_s, static_cast<std::size_t>(length_s / grid_s) + 1, smoothed);
  keep_strongest(std::array{&imu_axes[0], &imu_axes[1], &imu_axes[2]}, static_cast<std::size_t>(searched_s / grid_s));
  const Axes arm_axes = arm_acceleration(motion, smoothed);
  const double imu_energy = energy_of_all(imu_axes), arm_energy = energy_of_all(arm_axes);
  if (!(imu_energy > 0) || !(arm_energy > 0)) return std::nullopt;
  // A rotation of the sensor against the arm's base mixes the axes; the sum of all squares does not change with it.
  std::vector<double> scores;
  for (const auto& arm : arm_axes) {
    if (energy_of(arm) < least_share * arm_energy) continue;
    for (const auto& axis : imu_axes) {
      if (energy_of(axis) < least_share * imu_energy) continue;
      const std::vector<double> products = correlations(arm, axis);
      scores.resize(products.size());
      for (std::size_t i = 0; i < products.size(); ++i) scores[i] += products[i] * products[i];
    }
  }
  for (double& score : scores) score = std::sqrt(score / (imu_energy * arm_energy));
  const Lags lags{.grid_s = grid_s, .zero = arm_axes.front().size() - 1, .begin_s = velocity.begin_s()};
  keep_within(scores, lags, search);
  const std::optional<Peak> peak = highest_peak(scores);
  if (!peak) return std::nullopt;
  const double shift_s = lags.shift_of(static_cast<double>(peak->index) + peak->offset);
  std::vector<double> as_good_s;
  for (const std::size_t index :
       peaks_near_best(scores, 1.0 / search.options.ambiguous_below, static_cast<std::size_t>(same_shift_s / grid_s)))
    as_good_s.push_back(lags.shift_of(static_cast<double>(index)));
  return CoarseMatch{.match = {.offset_us = search.origins.offset_us(shift_s), .likeness = peak->value, .ratio = peak->ratio()},
                     .shift_s = shift_s,
                     .as_good_s = std::move(as_good_s)};
}

/// A stretch of the log with motion: the rows [begin, end).
struct Window {
  std::size_t begin = 0, end = 0;
  double middle_s = 0;  ///< robot seconds
};

/// A motion and the rest around it. Motions that are close are one window. None takes much more than ten seconds.
std::vector<Window> windows_of(const AnchorInputs& inputs, const ClockOrigins& origins) {
  constexpr double longest_s = 10.0, before_s = 0.08, after_s = 0.15, close_s = 0.25, longest_gap_s = 0.1;
  constexpr std::size_t fewest_rows = 12;
  std::vector<std::pair<double, double>> spans;
  for (const MotionPhase& motion : inputs.motions) {
    const double end_s = origins.seconds_of(motion.end);
    for (double from_s = origins.seconds_of(motion.start); from_s < end_s; from_s += longest_s) {
      const double to_s = std::min(end_s, from_s + longest_s);
      if (!spans.empty() && from_s - spans.back().second < close_s && to_s - spans.back().first <= longest_s) {
        spans.back().second = to_s;
      } else {
        spans.emplace_back(from_s, to_s);
      }
    }
  }
  const std::vector<robot::RobotState>& states = inputs.robot.states;
  const auto t = [&](std::size_t row) { return origins.seconds_of(states[row].t); };
  const auto row_at = [&](double t_s) {
    const auto row = std::partition_point(states.begin(), states.end(),
                                          [&](const robot::RobotState& state) { return origins.seconds_of(state.t) < t_s; });
    return static_cast<std::size_t>(row - states.begin());
  };
  std::vector<Window> windows;
  for (const auto& [from_s, to_s] : spans) {
    const Window window{.begin = row_at(from_s - before_s),
                        .end = row_at(to_s + after_s),
                        .middle_s = 0.5 * (from_s - before_s + to_s + after_s)};
    bool has_gap = false;
    for (std::size_t i = window.begin + 1; i < window.end; ++i) has_gap = has_gap || t(i) - t(i - 1) > longest_gap_s;
    if (!has_gap && window.end >= window.begin + fewest_rows) windows.push_back(window);
  }
  return windows;
}

struct TimedSpeed {
  double t_s = 0, v = 0;
};

/// The rows' speeds along the direction of the fastest.
std::vector<TimedSpeed> speeds_in(const Window& window, const robot::RobotLog& log, const ClockOrigins& origins) {
  const auto velocity = [&](std::size_t row) {
    const auto& v = log.states[row].tcp_speed;
    return Vector3{v[0], v[1], v[2]};
  };
  Vector3 direction{};
  double fastest = 0;
  for (std::size_t i = window.begin; i < window.end; ++i) {
    const Vector3 v = velocity(i);
    const double speed = length_of(v);
    if (!(speed > fastest)) continue;
    fastest = speed;
    direction = {v[0] / speed, v[1] / speed, v[2] / speed};
  }
  std::vector<TimedSpeed> speeds;
  for (std::size_t i = window.begin; i < window.end; ++i)
    speeds.push_back({origins.seconds_of(log.states[i].t), dot(direction, velocity(i))});
  return speeds;
}

/// The sum of squares that v = a + b t + c . IMU velocity leaves of v, as a share of what a + b t leaves; 1 where samples lack.
double unexplained(const std::vector<TimedSpeed>& rows, const ImuVelocity& imu, double shift_s) {
  constexpr int n = 5;  // 1, t, and three axes
  Eigen::Matrix<double, n + 1, n + 1> sums;
  sums.setZero();
  const double middle_s = 0.5 * (rows.front().t_s + rows.back().t_s);
  const std::optional<Vector3> origin = imu.at(rows.front().t_s + shift_s);
  if (!origin) return 1.0;
  for (const TimedSpeed& row : rows) {
    const std::optional<Vector3> moved = imu.at(row.t_s + shift_s);
    if (!moved) return 1.0;
    const Eigen::Vector<double, n + 1> terms{
        {1.0, row.t_s - middle_s, (*moved)[0] - (*origin)[0], (*moved)[1] - (*origin)[1], (*moved)[2] - (*origin)[2], row.v}};
    sums += terms * terms.transpose();
  }
  const auto left_by = [&sums](int first) {  // by this many of the terms, of v
    const auto products = sums.col(n).head(first);
    return sums(n, n) - products.dot(sums.topLeftCorner(first, first).ldlt().solve(products));
  };
  const double without_imu = left_by(2);
  return without_imu > 0 ? std::max(left_by(n), 0.0) / without_imu : 1.0;
}

/// Why a coarse match is refused; empty if it is not.
Doubt refusal_of(const std::optional<CoarseMatch>& coarse, const AnchorOptions& options) {
  if (!coarse) return doubt("imu-still", "the camera's IMU measured no motion, or the arm made none");
  const LagMatch& match = coarse->match;
  if (match.likeness < options.least_likeness) {
    return doubt("imu-unlike", "the IMU's acceleration does not match the arm's: likeness {:.2f}, expected at least {:.2f}",
                 match.likeness, options.least_likeness);
  }
  if (match.ratio < options.ambiguous_below) {
    return doubt(
        "imu-ambiguous",
        "the match of arm and IMU is ambiguous: the best lag is only {:.2f} times as good as the second, expected {:.2f}",
        match.ratio, options.ambiguous_below);
  }
  return {};
}

/// How far a shift may be off, and how much of a motion's speed the IMU may leave unexplained.
struct MotionLimits {
  double reach_s = 0, most_unexplained = 0;
};

/// What the IMU says of the arm's motions.
struct ExplainedMotions {
  std::optional<double> shift_s;  ///< of the first one that it explains
  bool contradicts = false;       ///< one lies whole within the IMU's samples, and is not explained
};

/// Adds an anchor for each stretch of motion that the IMU explains.
ExplainedMotions add_explained_motions(AnchorSearch& search, const ImuVelocity& velocity, double first_shift_s,
                                       const MotionLimits& limits) {
  // From the window nearest to the recording's middle outwards: a drift moves the later ones away.
  std::vector<Window> windows = windows_of(search.inputs, search.origins);
  KnownShifts known{.first_s = first_shift_s, .first_at_s = 0.5 * (velocity.begin_s() + velocity.end_s()) - first_shift_s};
  std::sort(windows.begin(), windows.end(), [&](const Window& a, const Window& b) {
    return std::abs(a.middle_s - known.first_at_s) < std::abs(b.middle_s - known.first_at_s);
  });
  constexpr double widest_drift = 200e-6, widest_s = 0.005;
  constexpr double floor_s = 200e-6;
  // A sample is stamped up to a quarter of a millisecond late, and the low-pass filter of the sensor delays it by about 1 ms
  // more.
  constexpr double common_s = 500e-6;
  bool contradicts = false;
  for (const Window& window : windows) {
    const KnownShifts::Nearest near = known.nearest(window.middle_s);
    const std::vector<TimedSpeed> rows = speeds_in(window, search.inputs.robot, search.origins);
    const auto cost = [&](double shift_s) { return unexplained(rows, velocity, shift_s); };
    const LowestPoint best = lowest_point(cost, near.shift_s, limits.reach_s + widest_drift * near.distance_s, 1e-3);
    contradicts = contradicts || (best.value >= limits.most_unexplained && best.value < 1);  // 1: samples lack
    if (!(best.value < limits.most_unexplained) || !(best.curvature > 0)) continue;
    // Twice the deviation of the least squares: their residual is the integral of noise, which wanders.
    const double sigma_s =
        std::hypot(floor_s, 2.0 * std::sqrt(2.0 * best.value / static_cast<double>(rows.size() - 6) / best.curvature));
    if (sigma_s > widest_s) continue;
    known.found.emplace_back(window.middle_s, best.at);
    search.add(window.middle_s, best.at, sigma_s, AnchorKind::imu, common_s);
  }
  if (known.found.empty()) return {.shift_s = {}, .contradicts = contradicts};
  return {.shift_s = known.found.front().second, .contradicts = contradicts};
}

}  // namespace

std::optional<double> add_imu_anchors(AnchorSearch& search, const ArmMotion& motion) {
  const ImuMotion imu = imu_motion(search.inputs.imu);
  if (imu.t.size() < 50) return std::nullopt;
  const ImuVelocity velocity(imu, search.origins);
  const std::optional<CoarseMatch> coarse = match_imu(search, motion, imu, velocity);
  if (coarse) search.found.imu = coarse->match;
  if (Doubt reason = refusal_of(coarse, search.options); !reason.empty()) {
    search.found.doubts.push_back(std::move(reason));
    if (coarse && coarse->match.likeness >= search.options.least_likeness) search.left_by_imu_s = coarse->as_good_s;
    return std::nullopt;
  }
  constexpr MotionLimits limits{.reach_s = 0.012, .most_unexplained = 0.25};
  if (const auto shift_s = add_explained_motions(search, velocity, coarse->shift_s, limits).shift_s) return shift_s;
  search.found.doubts.push_back(doubt("imu-too-short", "no motion of the arm lies whole within the IMU's samples"));
  return std::nullopt;
}

void add_imu_anchors_near(AnchorSearch& search, double shift_s) {
  // Where the log is the recording's own, less than 0.05 stays unexplained; where it is of another run with such a lift, mostly
  // more than 0.1.
  constexpr MotionLimits limits{.reach_s = 0.05, .most_unexplained = 0.1};
  const ImuMotion imu = imu_motion(search.inputs.imu);
  const ExplainedMotions motions = add_explained_motions(search, ImuVelocity(imu, search.origins), shift_s, limits);
  if (motions.shift_s || !motions.contradicts) return;
  search.found.contradictions.push_back(
      doubt("imu-unlike-arm",
            "the camera's IMU measured another motion than the robot log contains: the log may be of another recording"));
}

}  // namespace tactile::alignment
