#include "tactile/labels/clock_anchors.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/labels/correlation.hpp"
#include "tactile/labels/imu_motion.hpp"
#include "tactile/labels/lowest_point.hpp"
#include "tactile/labels/placed_motion.hpp"
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
  constexpr int n = 5;  // 1, t, and three axes
  Eigen::Matrix<double, n + 1, n + 1> sums;
  sums.setZero();
  const double middle_s = 0.5 * (rows.front().t_s + rows.back().t_s);
  std::array<double, 3> origin{};
  if (!felt.at(rows.front().t_s + shift_s, origin)) return 1.0;
  for (const TimedSpeed& row : rows) {
    std::array<double, 3> moved{};
    if (!felt.at(row.t_s + shift_s, moved)) return 1.0;
    const Eigen::Vector<double, n + 1> terms{
        {1.0, row.t_s - middle_s, moved[0] - origin[0], moved[1] - origin[1], moved[2] - origin[2], row.v}};
    sums += terms * terms.transpose();
  }
  const auto left_by = [&sums](int first) {  // by so many of the terms, of v
    const auto products = sums.col(n).head(first);
    return sums(n, n) - products.dot(sums.topLeftCorner(first, first).ldlt().solve(products));
  };
  const double without_felt = left_by(2);
  return without_felt > 0 ? std::max(left_by(n), 0.0) / without_felt : 1.0;
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
  const double limit = 3.0 * upper_median(sizes);
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
  speeds.reserve(states.size());
  for (const RobotState& state : states) speeds.push_back(std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]));
  const double limit = std::max(0.004, 4.2 * upper_median(speeds));
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

/// @return the clocks' shift, if it was found
std::optional<double> add_imu_anchors(FoundAnchors& found, const AnchorInputs& inputs, const AnchorOptions& options,
                                      const Origins& origins, const ArmMotion& motion) {
  const FeltMotion felt = felt_motion(inputs.imu);
  if (felt.t.size() < 50) return std::nullopt;
  const FeltVelocity velocity(felt, origins);
  const std::optional<CoarseMatch> coarse = match_imu(motion, felt, velocity, inputs, options, origins);
  if (!coarse) {
    found.doubts.push_back("the camera's inertial sensor felt no motion, or the arm made none");
    return std::nullopt;
  }
  found.imu = coarse->match;
  if (coarse->match.likeness < options.least_likeness) {
    found.doubts.push_back(
        fmt::format("the arm's acceleration is not what the camera's inertial sensor felt: likeness {:.2f}, expected at "
                    "least {:.2f}",
                    coarse->match.likeness, options.least_likeness));
    return std::nullopt;
  }
  if (coarse->match.ratio < options.ambiguous_below) {
    found.doubts.push_back(fmt::format(
        "where the arm's acceleration lies on the felt one is ambiguous: the best match is only {:.2f} times as good as the "
        "second, expected {:.2f}",
        coarse->match.ratio, options.ambiguous_below));
    return std::nullopt;
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
    const LowestPoint best = lowest_point(cost, expected, reach_s + widest_drift * distance, 1e-3);
    if (!(best.value < most_unexplained) || !(best.curvature > 0)) continue;
    // The least squares' own deviation, doubled: what is left is the integral of noise, which wanders.
    const double sigma_s =
        std::hypot(floor_s, 2.0 * std::sqrt(2.0 * best.value / static_cast<double>(rows.size() - 6) / best.curvature));
    if (sigma_s > 0.005) continue;
    known.emplace_back(stretch.middle_s, best.at);
    found.anchors.push_back(origins.anchor(stretch.middle_s, best.at, sigma_s, AnchorKind::imu, common_s));
  }
  if (known.empty()) {
    found.doubts.push_back("no stretch of the arm's motion lies whole within what the camera's inertial sensor felt");
    return std::nullopt;
  }
  return known.front().second;
}

// ------------------------------------------------------------------------------------------------------------- events

/// What the skin does on a grid of whole milliseconds: the root of how many events there are above the quiet rate, 0 where they
/// could be noise. The root tames the first shear and springing tips, which are far above the rest.
std::vector<double> activity_on_grid(const Milliseconds& ms, microseconds grid) {
  const auto width = static_cast<std::size_t>(std::max<std::int64_t>(1, grid / 1ms));
  std::vector<double> activity(ms.counts.size() / width);
  const double mean = ms.quiet * static_cast<double>(width);
  const double limit = 3.0 * std::sqrt(ms.dispersion * std::max(mean, 1.0));
  for (std::size_t i = 0; i < activity.size(); ++i) {
    double count = 0;
    for (std::size_t j = 0; j < width; ++j) count += ms.counts[i * width + j];
    activity[i] = count - mean > limit ? std::sqrt(count - mean) : 0.0;
  }
  return activity;
}

/// Where the arm's motion should be seen in the skin if it touches something: 1 while it moves (of a tap only round its lowest
/// point), less the mean over that and `flank_s` on either side, so that what stands out beyond a motion's ends counts against
/// it.
std::vector<double> motion_on_grid(const std::vector<CommandedMotion>& commanded, const Origins& origins, double grid_s,
                                   std::size_t points) {
  constexpr double flank_s = 0.15;
  std::vector<double> expected(points);
  std::vector<bool> near(points);
  const auto mark = [&](double from_s, double to_s, auto&& at) {
    const double first = std::max(0.0, std::ceil(from_s / grid_s));
    for (auto i = static_cast<std::size_t>(first); i < points && grid_s * static_cast<double>(i) <= to_s; ++i) at(i);
  };
  for (const CommandedMotion& motion : commanded) {
    double from_s = origins.seconds_of(motion.start()), to_s = origins.seconds_of(motion.end());
    if (motion.kind == CommandedMotion::Kind::there_and_back) {
      const double turn_s = origins.seconds_of(motion.time_at(motion.turn_s())), half_s = 0.15 * (to_s - from_s);
      from_s = turn_s - half_s;
      to_s = turn_s + half_s;
    }
    mark(from_s, to_s, [&](std::size_t i) { expected[i] = 1.0; });
    mark(from_s - flank_s, to_s + flank_s, [&](std::size_t i) { near[i] = true; });
  }
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < points; ++i) {
    sum += expected[i];
    count += near[i] ? 1.0 : 0.0;
  }
  for (std::size_t i = 0; i < points; ++i) expected[i] -= near[i] ? sum / count : 0.0;
  return expected;
}

/// A way in which the log may lie on the events.
struct Candidate {
  double shift_s = 0;
  double score = 0;  ///< of the correlation
  double worth = 0;  ///< with all that speaks for and against it
};

/// The highest points of the correlation of motion and activity, which are a tenth of a second apart at least.
std::vector<Candidate> candidates_of(const std::vector<CommandedMotion>& commanded, const std::vector<double>& activity,
                                     const AnchorInputs& inputs, const AnchorOptions& options, const Origins& origins) {
  constexpr double apart_s = 0.12, least_share = 0.5;
  constexpr std::size_t most = 12;
  const double grid_s = seconds(options.grid), log_s = origins.seconds_of(inputs.robot.states.back().t);
  const std::vector<double> expected = motion_on_grid(commanded, origins, grid_s, static_cast<std::size_t>(log_s / grid_s) + 1);
  std::vector<double> seen = activity;
  keep_strongest(std::array{&seen}, static_cast<std::size_t>(coarse_stretch_s / grid_s));
  const double energy = energy_of(seen) * energy_of(expected);
  if (!(energy > 0)) return {};
  std::vector<double> scores = correlations(expected, seen);
  for (double& score : scores) score /= std::sqrt(energy);
  const Lags lags{.grid_s = grid_s, .zero = expected.size() - 1};
  keep_within(scores, lags, inputs.coarse, origins);
  std::vector<Candidate> found;
  const auto apart = static_cast<std::size_t>(apart_s / grid_s);
  while (found.size() < most) {
    const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
    const double score = scores[best];
    if (!(score > 0) || (!found.empty() && score < least_share * found.front().score)) break;
    found.push_back({.shift_s = lags.shift_of(static_cast<double>(best)), .score = score, .worth = score});
    for (std::size_t i = best > apart ? best - apart : 0; i < std::min(scores.size(), best + apart + 1); ++i) scores[i] = 0;
  }
  return found;
}

bool is_lift(const CommandedMotion& motion) { return motion.kind == CommandedMotion::Kind::one_way && motion.direction[2] > 0.3; }

/// A change of an output that is taken for a stage's command.
struct StageCommand {
  double at_s = 0;  ///< robot seconds, the middle of the two rows between which it changed
  bool shuts = false;
};

std::vector<StageCommand> stage_commands(const RobotLog& log, const Origins& origins) {
  std::vector<StageCommand> commands;
  for (const OutputChange& change : log.output_changes) {
    commands.push_back({.at_s = 0.5 * (origins.seconds_of(change.last_before) + origins.seconds_of(change.at)),
                        .shuts = change.to > change.from});
  }
  return commands;
}

// From a stage's command to its contact; it is not known how far it travels.
constexpr double least_travel_s = 0.03, most_travel_s = 1.0;
// From a stage's opening until the tips are seen to move, and its spread.
constexpr double opening_s = 0.006, opening_sigma_s = 0.03;

/// Camera seconds at which the skin begins to do something, and how many events there were.
struct Begin {
  double at_s = 0, events = 0;
};

const Begin* begin_within(const std::vector<Begin>& begins, double from_s, double to_s) {
  for (const Begin& begin : begins) {
    if (begin.at_s >= from_s && begin.at_s <= to_s) return &begin;
  }
  return nullptr;
}

/// The skin's activity against everything that the log tells of arm and stage.
class EventMatch {
 public:
  EventMatch(const AnchorInputs& inputs, const AnchorOptions& options, const Origins& origins,
             std::vector<CommandedMotion> commanded)
      : inputs_(inputs),
        options_(options),
        origins_(origins),
        commanded_(std::move(commanded)),
        ms_(milliseconds_of(inputs.rate, inputs.quiet)),
        activity_(activity_on_grid(ms_, options.grid)),
        commands_(stage_commands(inputs.robot, origins)) {
    // Where nothing goes up the base's z axis points elsewhere, and any way may be the lift's.
    const bool has_lift = std::any_of(commanded_.begin(), commanded_.end(), is_lift);
    std::erase_if(commanded_, [&](const CommandedMotion& motion) {
      return has_lift && motion.kind == CommandedMotion::Kind::one_way && !is_lift(motion);
    });
    for (const Burst& burst : bursts_in(inputs.rate, inputs.quiet)) {
      begins_.push_back({.at_s = seconds(inputs.rate.bin) * static_cast<double>(burst.begin), .events = burst.events});
    }
    length_s_ = 1e-3 * static_cast<double>(ms_.counts.size());
  }

  bool has_motion() const { return !commanded_.empty(); }
  const std::vector<StageCommand>& commands() const { return commands_; }

  /// The best way in which motion and activity lie on each other, or nothing and why in `doubts`.
  std::optional<CoarseMatch> match(std::vector<std::string>& doubts) const {
    constexpr double same_s = 0.12, least_worth = 0.08;
    std::vector<Candidate> candidates = candidates_of(commanded_, activity_, inputs_, options_, origins_);
    for (Candidate& candidate : candidates) judge(candidate);
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.worth > b.worth; });
    if (candidates.empty() || candidates.front().worth < least_worth) {
      doubts.push_back("no activity of the skin is like the arm's motion");
      return std::nullopt;
    }
    const Candidate& best = candidates.front();
    double second = 0;
    for (const Candidate& other : candidates) {
      if (std::abs(other.shift_s - best.shift_s) > same_s) second = std::max(second, other.worth);
    }
    const CoarseMatch match{.match = {.offset_us = saturating_add(origins_.apart_us, std::llround(1e6 * best.shift_s)),
                                      .likeness = best.worth,
                                      .ratio = second > 0 ? best.worth / second : infinite},
                            .shift_s = best.shift_s};
    if (match.match.ratio < options_.ambiguous_below) {
      doubts.push_back(fmt::format(
          "where the arm's motion lies on the events is ambiguous: the best match is only {:.2f} times as good as "
          "the second, {:.2f} s away; expected {:.2f}",
          match.match.ratio, std::abs(second_shift(candidates, best, same_s) - best.shift_s), options_.ambiguous_below));
    }
    return match;
  }

  /// Lifts and taps, each to the millisecond, from the middle of the recording outwards: a drift moves the later ones away.
  void add_motion_anchors(FoundAnchors& found, double shift_s) const {
    constexpr double shear_common_s = 0.8e-3, tap_common_s = 0.4e-3, ring_common_s = 2e-3;
    std::vector<const CommandedMotion*> motions;
    for (const CommandedMotion& motion : commanded_) motions.push_back(&motion);
    const double middle_s = 0.5 * length_s_ - shift_s;
    const auto distance = [&](const CommandedMotion* motion) { return std::abs(begin_of(*motion) - middle_s); };
    std::stable_sort(motions.begin(), motions.end(),
                     [&](const CommandedMotion* a, const CommandedMotion* b) { return distance(a) < distance(b); });
    std::vector<std::pair<double, double>> known;
    for (const CommandedMotion* motion : motions) {
      const double begin_s = begin_of(*motion);
      double expected = shift_s, nearest = infinite;
      for (const auto& [at_s, found_s] : known) {
        if (std::abs(at_s - begin_s) >= nearest) continue;
        nearest = std::abs(at_s - begin_s);
        expected = found_s;
      }
      const bool is_tap = motion->kind == CommandedMotion::Kind::there_and_back;
      const std::optional<PlacedMotion> placed = is_tap ? place_tap(ms_, *motion, begin_s, expected)
                                                        : place_shear(ms_, *motion, begin_s, expected, options_.most_slack_m);
      if (!placed) continue;
      if (placed->likeness > 0.5) known.emplace_back(begin_s, placed->shift_s);
      // Half a period further on it rings alike.
      if (!is_tap && placed->sigma_s < 0.1 / std::max(1.0, motion->ringing_hz)) {
        if (const std::optional<PlacedMotion> ring = place_ring_down(ms_, *motion, begin_s, placed->shift_s)) {
          found.anchors.push_back(
              origins_.anchor(begin_s + motion->change_s[3], ring->shift_s, ring->sigma_s, AnchorKind::ring_down, ring_common_s));
        }
      }
      found.anchors.push_back(origins_.anchor(begin_s + (is_tap ? motion->turn_s() : motion->change_s[0]), placed->shift_s,
                                              std::hypot(placed->sigma_s, motion->sigma_s),
                                              is_tap ? AnchorKind::sync_tap : AnchorKind::first_shear,
                                              is_tap ? tap_common_s : std::hypot(shear_common_s, placed->common_s)));
    }
  }

  /// What the stage's commands did, the clocks being known to some hundredths of a second.
  void add_stage_anchors(FoundAnchors& found, double shift_s) const {
    constexpr double tolerance_s = 0.05;
    for (const StageCommand& command : commands_) {
      const double at_s = command.at_s + shift_s;
      const double from_s = command.shuts ? at_s + least_travel_s : at_s - tolerance_s;
      const Begin* begin = begin_within(begins_, from_s, at_s + (command.shuts ? most_travel_s : 2 * tolerance_s));
      if (begin != nullptr) found.anchors.push_back(stage_anchor(command, *begin));
    }
  }

  /// The stage's commands alone against what the skin began to do: for runs whose arm stands still.
  void match_stage(FoundAnchors& found) const {
    struct Way {
      double shift_s = 0, explained = 0;
    };
    std::vector<Way> ways;
    double all = 0;
    for (const Begin& begin : begins_) {
      all += std::max(0.0, begin.events);
      for (const StageCommand& command : commands_)
        ways.push_back({.shift_s = begin.at_s - command.at_s - delay_of(command), .explained = 0});
    }
    for (Way& way : ways) {
      std::vector<const Begin*> taken;
      for (const StageCommand& command : commands_) {
        const double at_s = command.at_s + way.shift_s;
        const double slack_s = 0.5 * (most_travel_s - least_travel_s);
        const Begin* begin = command.shuts ? begin_within(begins_, at_s - slack_s + delay_of(command), at_s + most_travel_s)
                                           : begin_within(begins_, at_s - 0.05, at_s + 0.1);
        if (begin == nullptr || std::find(taken.begin(), taken.end(), begin) != taken.end()) continue;
        taken.push_back(begin);
        way.explained += begin->events / all;
      }
    }
    std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.explained > b.explained; });
    if (ways.empty() || !(all > 0)) {
      found.doubts.push_back("the skin does nothing that a command to the stage could have done");
      return;
    }
    const auto other = std::find_if(ways.begin(), ways.end(), [&](const Way& way) {
      return std::abs(way.shift_s - ways.front().shift_s) > 0.5 * most_travel_s;
    });
    // One command has no pattern to be known by: the largest activity must be it beyond doubt.
    const double needed = commands_.size() == 1 ? std::max(3.0, options_.ambiguous_below) : options_.ambiguous_below;
    if (other != ways.end() && ways.front().explained < needed * other->explained) {
      found.doubts.push_back(
          fmt::format("which activity of the skin the stage's commands made is ambiguous: the best match explains only "
                      "{:.2f} times as many events as the second, expected {:.2f}",
                      ways.front().explained / other->explained, needed));
      return;
    }
    for (const StageCommand& command : commands_) {
      const double at_s = command.at_s + ways.front().shift_s;
      const Begin* begin = command.shuts ? begin_within(begins_, at_s - 0.2, at_s + most_travel_s)
                                         : begin_within(begins_, at_s - 0.05, at_s + 0.1);
      if (begin != nullptr) found.anchors.push_back(stage_anchor(command, *begin));
    }
  }

 private:
  double begin_of(const CommandedMotion& motion) const { return origins_.seconds_of(motion.begin); }
  double delay_of(const StageCommand& command) const { return command.shuts ? seconds(options_.stage_delay) : opening_s; }

  static double second_shift(const std::vector<Candidate>& candidates, const Candidate& best, double same_s) {
    for (const Candidate& other : candidates) {
      if (std::abs(other.shift_s - best.shift_s) > same_s) return other.shift_s;
    }
    return best.shift_s;
  }

  ClockAnchor stage_anchor(const StageCommand& command, const Begin& begin) const {
    // A third of what the travel may be more or less.
    const double sigma_s = command.shuts ? 0.5 * seconds(options_.stage_delay) : opening_sigma_s;
    return origins_.anchor(command.at_s, begin.at_s - command.at_s - delay_of(command), sigma_s, AnchorKind::stage_output,
                           0.5 * sigma_s);
  }

  void judge(Candidate& candidate) const {
    constexpr double rests_after_s = 0.3, command_fails = 0.6;
    double like = 0, lifts = 0, last_s = -infinite;
    for (const CommandedMotion& motion : commanded_) {
      const double begin_s = begin_of(motion);
      last_s = std::max(last_s, begin_s + motion.change_s[3] + candidate.shift_s);
      if (motion.kind != CommandedMotion::Kind::one_way) continue;
      ++lifts;
      const std::optional<PlacedMotion> placed = place_shear(ms_, motion, begin_s, candidate.shift_s, options_.most_slack_m);
      if (!placed) continue;
      like += placed->likeness;
      if (lifts == 1 && placed->likeness > 0.5) candidate.shift_s = placed->shift_s;
    }
    candidate.worth = candidate.score * (lifts > 0 ? 0.75 + 0.25 * like / lifts : 1.0);
    // What happens after the last motion has nothing to make it but a stage's opening.
    double before = 0, behind = 0;
    for (std::size_t i = 0; i < activity_.size(); ++i)
      (seconds(options_.grid) * static_cast<double>(i) > last_s + rests_after_s ? behind : before) += activity_[i];
    if (before + behind > 0) candidate.worth *= 0.7 + 0.3 * before / (before + behind);
    for (const StageCommand& command : commands_) {
      const double at_s = command.at_s + candidate.shift_s;
      if (at_s < 0 || at_s + most_travel_s > length_s_) continue;
      const Begin* begin =
          command.shuts ? begin_within(begins_, at_s, at_s + most_travel_s) : begin_within(begins_, at_s - 0.1, at_s + 0.2);
      if (begin == nullptr) candidate.worth *= command_fails;
    }
  }

  const AnchorInputs& inputs_;
  const AnchorOptions& options_;
  const Origins& origins_;
  std::vector<CommandedMotion> commanded_;
  Milliseconds ms_;
  std::vector<double> activity_;
  std::vector<StageCommand> commands_;
  std::vector<Begin> begins_;
  double length_s_ = 0;
};

// ---------------------------------------------------------------------------------------------------------- host times

/// Of each of some equal stretches of host time that both devices were heard in: how much later the host's clock is than the
/// device's, by the element that came soonest; late ones say nothing.
std::vector<ClockAnchor> host_anchors(const AnchorInputs& inputs) {
  constexpr microseconds least_stretch = 2s;
  constexpr std::int64_t most_stretches = 16;
  constexpr double sigma_us = 2'000, common_us = 4'000;  // the two ways to the host take some milliseconds, and not the same
  std::vector<std::pair<std::int64_t, std::int64_t>> robot, camera;  // host, and host - device
  std::int64_t difference = 0;
  for (const RobotState& state : inputs.robot.states) {
    if (state.host_time && !__builtin_sub_overflow(us_of(*state.host_time), us_of(state.t), &difference))
      robot.emplace_back(us_of(*state.host_time), difference);
  }
  for (const CameraArrival& arrival : inputs.host_from_camera) {
    if (!__builtin_sub_overflow(us_of(arrival.host), us_of(arrival.camera), &difference))
      camera.emplace_back(us_of(arrival.host), difference);
  }
  if (robot.empty() || camera.empty()) return {};
  const auto ends = [](const auto& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return std::pair(low->first, high->first);
  };
  const auto [robot_from, robot_to] = ends(robot);
  const auto [camera_from, camera_to] = ends(camera);
  const std::int64_t from = std::max(robot_from, camera_from), to = std::min(robot_to, camera_to);
  const std::int64_t span = saturating_subtract(to, from);
  if (span < 0) return {};
  const std::int64_t stretches = std::clamp<std::int64_t>(span / least_stretch.count(), 1, most_stretches);
  std::vector<ClockAnchor> anchors;
  for (std::int64_t k = 0; k < stretches; ++k) {
    const std::int64_t begin = from + span / stretches * k, end = k + 1 == stretches ? to : from + span / stretches * (k + 1);
    const auto soonest = [&](const auto& values) {
      std::optional<std::int64_t> least;
      for (const auto& [host, later] : values) {
        if (host >= begin && host <= end && (!least || later < *least)) least = later;
      }
      return least;
    };
    const auto of_robot = soonest(robot), of_camera = soonest(camera);
    if (!of_robot || !of_camera) continue;
    const std::int64_t middle = begin + (end - begin) / 2;
    anchors.push_back({.clock_us = saturating_subtract(middle, *of_robot),
                       .camera = camera_time(saturating_subtract(middle, *of_camera)),
                       .sigma_us = sigma_us,
                       .kind = AnchorKind::host_time,
                       .bias_us = common_us});
  }
  return anchors;
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
  AnchorInputs known = inputs;
  found.anchors = host_anchors(inputs);
  if (!found.anchors.empty()) {
    constexpr microseconds late = 250ms;
    const ClockAnchor& middle = found.anchors[found.anchors.size() / 2];
    known.coarse = CoarseOffset{saturating_subtract(us_of(middle.camera), middle.clock_us), late};
  }
  const std::optional<ArmMotion> motion = arm_motion(inputs.robot, {.step = options.grid});
  if (!motion) {
    found.doubts.push_back("the robot log is too short, or too long, to be laid over the recording");
    return found;
  }
  std::optional<double> shift_s;
  if (!inputs.imu.empty()) shift_s = add_imu_anchors(found, known, options, origins, *motion);

  const EventMatch events(known, options, origins, commanded_motions(inputs.robot));
  if (!shift_s && events.has_motion()) {
    if (const std::optional<CoarseMatch> match = events.match(found.doubts)) {
      found.events = match->match;
      if (match->match.ratio >= options.ambiguous_below) shift_s = match->shift_s;
    }
  }
  if (shift_s) {
    events.add_motion_anchors(found, *shift_s);
    events.add_stage_anchors(found, *shift_s);
  } else if (!events.commands().empty()) {
    events.match_stage(found);
  } else if (!events.has_motion()) {
    found.doubts.push_back("the arm does not move, and no output changes: nothing of the log is seen in the recording");
  }
  std::stable_sort(found.anchors.begin(), found.anchors.end(), [](const ClockAnchor& a, const ClockAnchor& b) {
    return std::pair(a.kind, a.clock_us) < std::pair(b.kind, b.clock_us);
  });
  return found;
}

}  // namespace tactile
