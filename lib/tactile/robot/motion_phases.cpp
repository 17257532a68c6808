#include "tactile/robot/motion_phases.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "tactile/core/robust_statistics.hpp"

namespace tactile {
namespace {

using Speed = SpeedProfile::Speed;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double chi3_median = 1.538;                  // of the length of three noisy components, in their standard deviations
constexpr double noise_factor = 5.0;                   // beyond the median length that noise alone has
constexpr double longest_pause_s = 0.06;               // the arm rests for longer between two stretches
constexpr double rest_before_s = 0.15, tail_s = 0.35;  // that a fit takes in
constexpr double longest_fit_s = 2.0;                  // longer stretches are fitted at their ends
constexpr std::size_t most_lobes_fitted = 3;
constexpr std::size_t most_rows_fitted = 2'500;  // no controller sends more in that time; of more every second, or third ...
constexpr double edge_s = 0.4;                   // that such a fit takes of the motion
constexpr double least_share = 0.25;             // of the greatest way: what goes less far is ringing, or a motion of its own
constexpr double ringing_share = 0.1;            // of the peak speed: what a fit may leave of a ringing
constexpr double ringing_lasts_s = 0.3;
constexpr double peak_share = 0.5;       // of the ramps: a height that is shorter may be a mere peak, rounded by ringing
constexpr double time_sigma_us = 100.0;  // controllers stamp no better
constexpr double longest_dwell_s = 0.1;  // of a tap
constexpr double longest_step_s = 0.1;   // of the rows; longer ones are gaps
constexpr double least_dwell_s = 0.04;   // shorter ones are passed through

double length(const Speed& v) { return std::hypot(v[0], v[1], v[2]); }
double dot(const Speed& a, const Speed& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Rows in which the arm moves one way.
struct Lobe {
  std::size_t begin = 0, end = 0;  ///< the rows, [begin, end)
  double way = 0;                  ///< [m] against the stretch's direction: negative
};

/// A time in seconds of the log and its standard deviation.
struct Instant {
  double t_s = 0;
  double sigma_s = infinite;
};

/// Where a straight line meets zero.
Instant zero_of_line(std::span<const std::pair<double, double>> points, double noise, double period_s, bool rising) {
  double n = 0, t_mean = 0, v_mean = 0;
  for (const auto& [t, v] : points) {
    n += 1;
    t_mean += t;
    v_mean += v;
  }
  t_mean /= n;
  v_mean /= n;
  double tt = 0, tv = 0;
  for (const auto& [t, v] : points) {
    tt += (t - t_mean) * (t - t_mean);
    tv += (t - t_mean) * (v - v_mean);
  }
  const double slope = tt > 0 ? tv / tt : 0.0;
  if (points.size() < 2 || (rising ? slope <= 0 : slope >= 0)) return {};
  const double zero = t_mean - v_mean / slope;
  double squares = 0;
  for (const auto& [t, v] : points) squares += std::pow(v - slope * (t - zero), 2.0);
  const double sigma = std::max(noise, std::sqrt(squares / std::max(1.0, n - 2.0)));
  const double by_noise = sigma / std::abs(slope) * std::sqrt(1.0 / n + (zero - t_mean) * (zero - t_mean) / tt);
  return {zero, std::hypot(by_noise, points.size() < 3 ? period_s : 0.3 * period_s)};
}

/// Finds the phases of one log. Its rows' speeds lose what is explained as it goes on.
class Finder {
 public:
  Finder(const RobotLog& log, const MotionPhaseOptions& options) : log_(log), options_(options) {
    const RobotTime first = log.states.front().t;
    rows_.reserve(log.states.size());
    for (const RobotState& state : log.states) {
      rows_.push_back({.t_s = 1e-6 * static_cast<double>((state.t - first).count()),
                       .speed = {state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]}});
    }
    noise_ = std::max(speed_noise(log), 1e-6);
    limit_ = std::max(options.slowest, (chi3_median + noise_factor) * noise_);
    const double rate = rate_hz(log);
    period_s_ = rate > 0 ? 1.0 / rate : 0.008;
    longest_pause_s_ = std::max(longest_pause_s, 2.5 * period_s_);
    least_dwell_s_ = std::max(least_dwell_s, 2.5 * period_s_);
  }

  std::vector<MotionPhase> phases() {
    for (std::size_t i = 0; i < rows_.size();) {
      if (!moves(i)) {
        ++i;
        continue;
      }
      const std::size_t end = stretch_end(i);
      i = std::max(i + 1, take(i, end));
    }
    return join_taps();
  }

 private:
  double limit_at(std::size_t row) const { return rows_[row].t_s < ringing_until_s_ ? std::max(limit_, ringing_limit_) : limit_; }
  bool moves(std::size_t row) const { return length(rows_[row].speed) >= limit_at(row); }
  bool gap_before(std::size_t row) const { return row > 0 && rows_[row].t_s - rows_[row - 1].t_s > longest_step_s; }

  /// Behind the last row that moves, pauses of 60 ms not counting.
  std::size_t stretch_end(std::size_t begin) const {
    std::size_t end = begin + 1;
    for (std::size_t i = end; i < rows_.size() && !gap_before(i); ++i) {
      if (moves(i)) {
        end = i + 1;
      } else if (rows_[i].t_s - rows_[end - 1].t_s > longest_pause_s_) {
        break;
      }
    }
    return end;
  }

  Speed direction_in(std::size_t begin, std::size_t end) const {
    const auto fastest =
        std::max_element(rows_.begin() + static_cast<std::ptrdiff_t>(begin), rows_.begin() + static_cast<std::ptrdiff_t>(end),
                         [](const SpeedRow& a, const SpeedRow& b) { return length(a.speed) < length(b.speed); });
    Speed direction = fastest->speed;
    const double size = length(direction);
    for (double& part : direction) part /= size;
    return direction;
  }

  /// The stretch's rows by the way they go, those between two lobes left out.
  std::vector<Lobe> lobes_in(std::size_t begin, std::size_t end, const Speed& direction) const {
    std::vector<Lobe> lobes;
    int sign = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!moves(i)) continue;
      const double size = length(rows_[i].speed), along = dot(rows_[i].speed, direction);
      const int way = along >= 0.5 * size ? 1 : along <= -0.5 * size ? -1 : sign;
      const bool paused = !lobes.empty() && rows_[i].t_s - rows_[lobes.back().end - 1].t_s > least_dwell_s_;
      if (lobes.empty() || paused || (way != sign && sign != 0)) lobes.push_back({i, i, 0.0});
      sign = way == 0 ? 1 : way;
      lobes.back().end = i + 1;
      const double step = i > begin ? std::min(rows_[i].t_s - rows_[i - 1].t_s, 0.05) : period_s_;
      lobes.back().way += sign * size * step;
    }
    double farthest = 0;
    for (const Lobe& lobe : lobes) farthest = std::max(farthest, std::abs(lobe.way));
    std::erase_if(lobes, [&](const Lobe& lobe) { return std::abs(lobe.way) < least_share * farthest; });
    // Two that go the same way, nothing great between them: one motion with a pause.
    return lobes;
  }

  /// Where a lobe's speed leaves zero, reaches its height, leaves that, and is back at zero; roughly.
  struct Corners {
    double start_s = 0, up_s = 0, down_s = 0, end_s = 0, height = 0;
  };
  Corners corners_of(const Lobe& lobe) const {
    std::vector<double> sizes;
    for (std::size_t i = lobe.begin; i < lobe.end; ++i) sizes.push_back(length(rows_[i].speed));
    Corners corners;
    corners.height = value_of_rank(sizes, sizes.size() * 4 / 5);
    const auto first_at = [&](double level) {
      std::size_t i = 0;
      while (i + 1 < sizes.size() && sizes[i] < level) ++i;
      return rows_[lobe.begin + i].t_s;
    };
    const auto last_at = [&](double level) {
      std::size_t i = sizes.size() - 1;
      while (i > 0 && sizes[i] < level) --i;
      return rows_[lobe.begin + i].t_s;
    };
    const double low_level = 0.2 * corners.height, high_level = 0.9 * corners.height;
    const double rise = std::max(first_at(high_level) - first_at(low_level), 0.5 * period_s_);
    const double fall = std::max(last_at(low_level) - last_at(high_level), 0.5 * period_s_);
    corners.start_s = first_at(low_level) - 0.3 * rise;
    corners.up_s = first_at(high_level) + 0.1 * rise;
    corners.down_s = std::max(last_at(high_level) - 0.1 * fall, corners.up_s);
    corners.end_s = std::max(last_at(low_level) + 0.3 * fall, corners.down_s + 0.5 * period_s_);
    return corners;
  }

  static void add_knot(std::vector<double>& knots, double t_s) {
    knots.push_back(knots.empty() ? t_s : std::max(t_s, knots.back() + 0.002));
  }

  /// Knots of a height: its two ends, or its middle if it is hardly one.
  void add_height(std::vector<double>& knots, const Corners& corners, bool may_be_peak) const {
    const double ramps = corners.up_s - corners.start_s + corners.end_s - corners.down_s;
    const double least = std::max({0.02, 2.0 * period_s_, may_be_peak ? peak_share * ramps : 0.0});
    if (corners.down_s - corners.up_s < least) {
      add_knot(knots, 0.5 * (corners.up_s + corners.down_s));
    } else {
      add_knot(knots, corners.up_s);
      add_knot(knots, corners.down_s);
    }
  }

  std::size_t row_at_or_after(double t_s) const {
    const auto found = std::partition_point(rows_.begin(), rows_.end(), [&](const SpeedRow& row) { return row.t_s < t_s; });
    return static_cast<std::size_t>(found - rows_.begin());
  }

  std::optional<SpeedProfile> fit(double from_s, double to_s, std::vector<double> knots, std::vector<double> other_knots,
                                  bool open_begin, bool open_end) const {
    const std::size_t begin = row_at_or_after(from_s), end = row_at_or_after(to_s);
    if (end <= begin) return std::nullopt;
    std::vector<SpeedRow> rows;
    const std::size_t stride = (end - begin + most_rows_fitted - 1) / most_rows_fitted;
    for (std::size_t i = begin; i < end; i += stride) rows.push_back(rows_[i]);
    return fit_speed_profile(rows, {.noise = noise_,
                                    .smoothed_s = 1e-6 * static_cast<double>(log_.smoothed_over.count()),
                                    .knots_s = std::move(knots),
                                    .other_knots_s = std::move(other_knots),
                                    .open_begin = open_begin,
                                    .open_end = open_end,
                                    .ringing = ringing_});
  }

  /// The rest before `row`: back to where the last motion ended or a gap is, but not far.
  double rest_begin_s(std::size_t row) const {
    std::size_t i = row;
    while (i > 0 && !gap_before(i) && rows_[row].t_s - rows_[i - 1].t_s <= rest_before_s && rows_[i - 1].t_s > explained_until_s_)
      --i;
    return rows_[i].t_s;
  }

  /// The ring-down behind `end`, up to the next motion that goes as far as a share of `way` or a gap.
  double tail_end_s(std::size_t end, double way) const {
    const double until_s = rows_[end - 1].t_s + tail_s;
    double gone = 0, since_s = infinite;
    for (std::size_t i = end; i < rows_.size(); ++i) {
      if (gap_before(i)) return std::min(rows_[i].t_s, until_s);
      if (moves(i)) {
        since_s = std::min(since_s, rows_[i].t_s);
        gone += length(rows_[i].speed) * (rows_[i].t_s - rows_[i - 1].t_s);
        if (gone > least_share * way) return std::min(until_s, std::max(since_s - 0.02, rows_[end].t_s));
      } else {
        gone = 0;
        since_s = infinite;
        if (rows_[i].t_s > until_s) break;
      }
    }
    return until_s;
  }

  /// The phases of a stretch. @return the row to go on from
  std::size_t take(std::size_t begin, std::size_t end) {
    const bool moves_at_begin = begin == 0 || gap_before(begin);
    const bool moves_at_end = end == rows_.size() || gap_before(end);
    const double from_s = rows_[moves_at_begin ? begin : begin - 1].t_s, to_s = rows_[moves_at_end ? end - 1 : end].t_s;
    if (to_s - from_s < 1e-6 * static_cast<double>(options_.shortest.count())) return end;

    const Speed direction = direction_in(begin, end);
    const std::vector<Lobe> lobes = lobes_in(begin, end, direction);
    std::vector<Corners> corners;
    double farthest = 0;
    for (const Lobe& lobe : lobes) {
      corners.push_back(corners_of(lobe));
      farthest = std::max(farthest, std::abs(lobe.way));
    }
    const bool open_begin = moves_at_begin && lobes.front().begin == begin, open_end = moves_at_end && lobes.back().end == end;
    const double window_begin_s = open_begin ? rows_[begin].t_s : rest_begin_s(lobes.front().begin);
    const double window_end_s = open_end ? rows_[end - 1].t_s + 0.5 * period_s_ : tail_end_s(lobes.back().end, farthest);

    std::optional<SpeedProfile> start_fit, end_fit;
    const bool whole = corners.back().end_s - corners.front().start_s <= longest_fit_s && lobes.size() <= most_lobes_fitted;
    if (whole) {
      const auto knots = [&](bool may_be_peak) {
        std::vector<double> all;
        add_knot(all, open_begin ? window_begin_s : std::max(corners.front().start_s, window_begin_s));
        for (std::size_t i = 0; i < lobes.size(); ++i) {
          if (i > 0 && corners[i].start_s - corners[i - 1].end_s > least_dwell_s_) {
            add_knot(all, corners[i - 1].end_s);
            add_knot(all, corners[i].start_s);
          }
          add_height(all, corners[i], may_be_peak);
        }
        add_knot(all, open_end ? window_end_s : corners.back().end_s);
        return all;
      };
      std::vector<double> peaked = knots(true), flat = knots(false);
      if (flat == peaked) flat.clear();
      start_fit = end_fit = fit(window_begin_s, window_end_s, std::move(peaked), std::move(flat), open_begin, open_end);
    } else {
      const Corners &first = corners.front(), &last = corners.back();
      if (!open_begin) {
        const double until_s = std::min(first.up_s + edge_s, std::max(first.down_s, first.up_s + 4.0 * period_s_));
        start_fit = fit(window_begin_s, until_s, {first.start_s, first.up_s, until_s}, {}, false, true);
      }
      if (!open_end) {
        const double since_s = std::max(last.down_s - edge_s, std::min(last.up_s, last.down_s - 4.0 * period_s_));
        end_fit = fit(since_s, window_end_s, {since_s, last.down_s, last.end_s}, {}, true, false);
      }
    }
    // A fit that has run away from what one sees is none.
    const auto is_near = [](double fitted_s, double seen_s) { return std::abs(fitted_s - seen_s) < 0.1; };
    if (start_fit && !open_begin && !is_near(start_fit->knots_s.front(), corners.front().start_s)) start_fit.reset();
    if (end_fit && !open_end && !is_near(end_fit->knots_s.back(), corners.back().end_s)) end_fit.reset();
    if (whole && (!start_fit || !end_fit)) {
      start_fit.reset();
      end_fit.reset();
    }

    Instant start{rows_[begin].t_s, infinite}, stop{rows_[end - 1].t_s, infinite};
    if (!open_begin)
      start = start_fit ? Instant{start_fit->knots_s.front(), start_fit->sigma_s(0)} : edge_of(lobes.front(), true);
    if (!open_end) {
      stop = end_fit ? Instant{end_fit->knots_s.back(), end_fit->sigma_s(end_fit->knots_s.size() - 1)}
                     : edge_of(lobes.back(), false);
    }
    if (!(stop.t_s > start.t_s)) {
      start.t_s = rows_[begin].t_s;
      stop.t_s = std::max(rows_[end - 1].t_s, start.t_s + period_s_);
    }

    Instant from = start;
    for (std::size_t i = 0; i < lobes.size(); ++i) {
      const bool last = i + 1 == lobes.size();
      Instant until = stop, next = stop;
      if (!last) std::tie(until, next) = between(lobes[i], lobes[i + 1], whole ? start_fit : std::nullopt, direction);
      until.t_s = std::clamp(until.t_s, from.t_s, stop.t_s);
      next.t_s = std::clamp(next.t_s, until.t_s, stop.t_s);
      add_phase(lobes[i], from, until, start_fit ? start_fit : end_fit, whole);
      from = next;
    }

    explained_until_s_ = stop.t_s;
    if (const auto& profile = start_fit ? start_fit : end_fit) ringing_ = profile->ringing;
    if (!end_fit || open_end) return std::max(end, row_at_or_after(stop.t_s));
    const std::size_t first_row = row_at_or_after(end_fit->knots_s.front());
    const double faded_s = stop.t_s + 12.0 * end_fit->ringing.decay_s;
    for (std::size_t i = first_row; i < rows_.size() && rows_[i].t_s <= faded_s; ++i) {
      const Speed commanded = end_fit->commanded_at(rows_[i].t_s), ringing = end_fit->ringing_at(rows_[i].t_s);
      for (std::size_t a = 0; a < 3; ++a) rows_[i].speed[a] -= commanded[a] + ringing[a];
    }
    ringing_until_s_ = stop.t_s + ringing_lasts_s;
    ringing_limit_ = ringing_share * phases_.back().peak_speed;
    return row_at_or_after(stop.t_s);
  }

  /// Where a lobe begins or ends, by a line through its speeds between a tenth and six tenths of their height.
  Instant edge_of(const Lobe& lobe, bool is_start) const {
    const Corners corners = corners_of(lobe);
    std::vector<std::pair<double, double>> points;
    for (std::size_t k = 0; k < lobe.end - lobe.begin; ++k) {
      const SpeedRow& row = rows_[is_start ? lobe.begin + k : lobe.end - 1 - k];
      const double size = length(row.speed);
      if (size > 0.6 * corners.height && points.size() > 1) break;
      if (size >= 0.1 * corners.height) points.emplace_back(row.t_s, size);
      if (size > 0.6 * corners.height) break;
    }
    const double rest_s = is_start ? rows_[lobe.begin > 0 && !gap_before(lobe.begin) ? lobe.begin - 1 : lobe.begin].t_s
                                   : rows_[lobe.end < rows_.size() && !gap_before(lobe.end) ? lobe.end : lobe.end - 1].t_s;
    const Instant zero = points.empty() ? Instant{} : zero_of_line(points, noise_, period_s_, is_start);
    const double moving_s = rows_[is_start ? lobe.begin : lobe.end - 1].t_s;
    const bool is_likely =
        is_start ? zero.t_s <= moving_s && zero.t_s > rest_s - 0.05 : zero.t_s >= moving_s && zero.t_s < rest_s + 0.05;
    if (zero.sigma_s < infinite && is_likely) return zero;
    return {rest_s, std::max(period_s_, std::abs(moving_s - rest_s))};
  }

  /// The end of a lobe and the start of the next: one instant, or two if the arm rests in between.
  std::pair<Instant, Instant> between(const Lobe& before, const Lobe& after, const std::optional<SpeedProfile>& profile,
                                      const Speed& direction) const {
    const double from_s = rows_[before.end - 1].t_s, to_s = rows_[after.begin].t_s;
    const double middle_s = 0.5 * (from_s + to_s);
    const Instant seen{middle_s, std::max(0.5 * (to_s - from_s), 0.5 * period_s_)};
    const bool turns = (before.way < 0) != (after.way < 0);
    if (!profile) {
      if (to_s - from_s > least_dwell_s_) return {edge_of(before, false), edge_of(after, true)};
      return {seen, seen};
    }
    // The commanded speed between the two heights: where it passes through zero, or stays there.
    const std::size_t knots = profile->knots_s.size();
    std::optional<std::size_t> rests;
    for (std::size_t k = 1; k < knots; ++k) {
      const double a = dot(profile->speeds[k - 1], direction), b = dot(profile->speeds[k], direction);
      const double t = profile->knots_s[k - 1], u = profile->knots_s[k];
      if (u < from_s - 0.05 || t > to_s + 0.05) continue;
      const double small = std::max(limit_, 3.0 * profile->speed_sigma);
      if (k > 1 && k + 1 < knots && std::abs(a) < small && std::abs(b) < small && u - t > 0.5 * least_dwell_s_) rests = k;
      if (turns && a * b < 0 && !rests) {
        const double share = a / (a - b), slope = std::abs(b - a) / (u - t);
        const double rows = std::max(1.0, (u - t) / period_s_);
        const Instant zero{t + share * (u - t), 1.5 * profile->speed_sigma / slope / std::sqrt(rows)};
        return {zero, zero};
      }
    }
    if (rests)
      return {{profile->knots_s[*rests - 1], profile->sigma_s(*rests - 1)}, {profile->knots_s[*rests], profile->sigma_s(*rests)}};
    return {seen, seen};
  }

  RobotTime time_at(double t_s) const { return log_.states.front().t + microseconds{std::llround(1e6 * t_s)}; }

  void add_phase(const Lobe& lobe, const Instant& start, const Instant& end, const std::optional<SpeedProfile>& profile,
                 bool whole) {
    MotionPhase phase;
    phase.start = time_at(start.t_s);
    phase.end = time_at(end.t_s);
    phase.start_sigma_us = std::hypot(1e6 * start.sigma_s, time_sigma_us);
    phase.end_sigma_us = std::hypot(1e6 * end.sigma_s, time_sigma_us);
    for (std::size_t k = 0; profile && whole && k < profile->knots_s.size(); ++k) {
      if (profile->knots_s[k] >= start.t_s && profile->knots_s[k] <= end.t_s)
        phase.peak_speed = std::max(phase.peak_speed, length(profile->speeds[k]));
    }
    if (phase.peak_speed == 0) phase.peak_speed = corners_of(lobe).height;
    if (profile) phase.ringing = profile->ringing;

    std::size_t first = std::min(row_at_or_after(start.t_s), rows_.size() - 1);
    std::size_t last = std::min(row_at_or_after(end.t_s), rows_.size() - 1);
    if (first > 0 && !gap_before(first)) --first;
    if (last > 0 && gap_before(last) && rows_[last].t_s > end.t_s) --last;
    const RobotState &before = log_.states[std::min(first, last)], &after = log_.states[last];
    for (std::size_t a = 0; a < 3; ++a) phase.displacement[a] = after.tcp_pose[a] - before.tcp_pose[a];
    phase.height_change = phase.displacement[2];
    const double upright = std::sqrt(0.5) * length(phase.displacement);
    phase.kind = phase.height_change > 0 && phase.height_change >= upright    ? MotionKind::lift
                 : phase.height_change < 0 && -phase.height_change >= upright ? MotionKind::lower
                                                                              : MotionKind::sideways;
    phases_.push_back(phase);
  }

  std::vector<MotionPhase> join_taps() const {
    std::vector<MotionPhase> joined;
    for (const MotionPhase& phase : phases_) {
      if (!joined.empty() && is_way_back(joined.back(), phase)) {
        MotionPhase& tap = joined.back();
        tap.kind = MotionKind::tap;
        tap.turn = tap.end + (phase.start - tap.end) / 2;
        tap.turn_sigma_us = std::hypot(std::max(tap.end_sigma_us, phase.start_sigma_us),
                                       static_cast<double>((phase.start - tap.end).count()) / 4.0);
        tap.end = phase.end;
        tap.end_sigma_us = phase.end_sigma_us;
        tap.peak_speed = std::max(tap.peak_speed, phase.peak_speed);
        for (std::size_t a = 0; a < 3; ++a) tap.displacement[a] += phase.displacement[a];
        tap.height_change += phase.height_change;
      } else {
        joined.push_back(phase);
      }
    }
    return joined;
  }

  bool is_way_back(const MotionPhase& there, const MotionPhase& back) const {
    if (there.kind == MotionKind::tap || there.kind == MotionKind::lift) return false;
    if (back.start - there.end > microseconds{std::llround(1e6 * longest_dwell_s)}) return false;
    if (back.end - there.start > options_.longest_tap) return false;
    Speed left = there.displacement;
    for (std::size_t a = 0; a < 3; ++a) left[a] += back.displacement[a];
    return length(left) <= 0.2 * length(there.displacement);
  }

  const RobotLog& log_;
  const MotionPhaseOptions& options_;
  std::vector<SpeedRow> rows_;
  double noise_ = 0, limit_ = 0, period_s_ = 0.008;
  double longest_pause_s_ = longest_pause_s, least_dwell_s_ = least_dwell_s;
  double explained_until_s_ = -infinite;  ///< the last motion's end
  double ringing_until_s_ = -infinite, ringing_limit_ = 0;
  std::optional<ArmRinging> ringing_;  ///< of the last motion
  std::vector<MotionPhase> phases_;
};

}  // namespace

std::string_view name_of(MotionKind kind) {
  switch (kind) {
    case MotionKind::lift:
      return "lift";
    case MotionKind::lower:
      return "lower";
    case MotionKind::sideways:
      return "sideways";
    case MotionKind::tap:
      return "tap";
  }
  return "";
}

double speed_noise(const RobotLog& log) {
  constexpr microseconds apart{24'000}, too_far{60'000};
  std::vector<double> differences;
  std::size_t j = 0;
  for (const RobotState& state : log.states) {
    while (j < log.states.size() && log.states[j].t - state.t < apart) ++j;
    if (j == log.states.size()) break;
    if (log.states[j].t - state.t > too_far) continue;
    const RobotState& later = log.states[j];
    differences.push_back(std::hypot(later.tcp_speed[0] - state.tcp_speed[0], later.tcp_speed[1] - state.tcp_speed[1],
                                     later.tcp_speed[2] - state.tcp_speed[2]));
  }
  if (differences.size() < 8) return 0.0;
  return upper_median(differences) / (chi3_median * std::sqrt(2.0));
}

std::vector<MotionPhase> motion_phases(const RobotLog& log, const MotionPhaseOptions& options) {
  return log.states.empty() ? std::vector<MotionPhase>() : Finder(log, options).phases();
}

}  // namespace tactile
