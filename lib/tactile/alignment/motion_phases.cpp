#include "tactile/alignment/motion_phases.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "tactile/alignment/motion_lobes.hpp"
#include "tactile/alignment/motion_rows.hpp"
#include "tactile/core/infinite.hpp"

namespace tactile::alignment {
namespace {

using Speed = SpeedProfile::Speed;

constexpr double longest_fit_s = 2.0;  // longer stretches are fitted at their ends
constexpr std::size_t most_lobes_fitted = 3;
constexpr std::size_t most_rows_fitted = 2'500;  // of more, every second, third, ...
constexpr double edge_s = 0.4;                   // of the motion, in a fit of one end
constexpr double peak_share = 0.5;               // of the ramps: a height that is shorter may be a peak, rounded by ringing
constexpr double time_sigma_us = 100.0;          // controllers stamp no better
constexpr double longest_dwell_s = 0.1;          // of a tap
constexpr double farthest_s = 0.1;               // of a fitted start or end from the seen one

void add_knot(std::vector<double>& knots, double t_s) {
  knots.push_back(knots.empty() ? t_s : std::max(t_s, knots.back() + 0.002));
}

SpeedProfile shifted(SpeedProfile profile, double by_s) {
  for (double& knot : profile.knots_s) knot += by_s;
  return profile;
}

/// One stretch of motion while its phases are found.
struct Stretch {
  std::size_t begin = 0, end = 0;  ///< rows, [begin, end)
  Speed direction{};
  std::vector<MotionLobe> lobes{};
  std::vector<LobeCorners> corners{};                  ///< of each lobe
  bool open_begin = false, open_end = false;           ///< the arm moves where the rows begin, or end
  double window_begin_s = 0, window_end_s = 0;         ///< what a fit takes in
  bool whole = false;                                  ///< one fit takes in all of it
  std::optional<SpeedProfile> start_fit{}, end_fit{};  ///< the same if `whole`
  UncertainSeconds start{}, stop{};

  const std::optional<SpeedProfile>& any_fit() const { return start_fit ? start_fit : end_fit; }

  /// The profile of the whole stretch, if it is known.
  std::optional<SpeedProfile> profile() const {
    if (whole || !start_fit || !end_fit) return whole ? start_fit : std::nullopt;
    SpeedProfile joined = *start_fit;
    if (!(joined.knots_s.back() < end_fit->knots_s.front())) return std::nullopt;
    joined.append(*end_fit);
    return joined;
  }
};

/// Finds the phases of one log.
class PhaseFinder {
 public:
  PhaseFinder(const robot::RobotLog& log, const MotionPhaseOptions& options)
      : log_(log), options_(options), rows_(log, options.slowest), least_dwell_s_(least_dwell_s(rows_)) {}

  std::vector<MotionPhase> phases() {
    for (std::size_t i = 0; i < rows_.size();) {
      if (!rows_.moves(i)) {
        ++i;
        continue;
      }
      i = std::max(i + 1, take(i, rows_.stretch_end(i)));
    }
    return join_taps();
  }

 private:
  /// Adds the phases of a stretch. @return the row to continue from
  std::size_t take(std::size_t begin, std::size_t end) {
    const bool moves_at_begin = begin == 0 || rows_.gap_before(begin);
    const bool moves_at_end = end == rows_.size() || rows_.gap_before(end);
    const double from_s = rows_.t_s(moves_at_begin ? begin : begin - 1), to_s = rows_.t_s(moves_at_end ? end - 1 : end);
    if (to_s - from_s < 1e-6 * static_cast<double>(options_.shortest.count())) return end;

    Stretch stretch = stretch_of(begin, end, moves_at_begin, moves_at_end);
    fit(stretch);
    set_ends(stretch);
    add_phases(stretch);

    rows_.end_motion(stretch.stop.t_s);
    if (stretch.any_fit()) ringing_ = stretch.any_fit()->ringing;
    const std::size_t next = rows_.row_at_or_after(stretch.stop.t_s);
    if (!stretch.end_fit || stretch.open_end) return std::max(end, next);
    rows_.subtract(*stretch.end_fit, stretch.stop.t_s, phases_.back().peak_speed);
    return next;
  }

  Stretch stretch_of(std::size_t begin, std::size_t end, bool moves_at_begin, bool moves_at_end) const {
    Stretch stretch{.begin = begin, .end = end, .direction = direction_in(rows_, begin, end)};
    stretch.lobes = lobes_in(rows_, begin, end, stretch.direction);
    double farthest_m = 0;
    for (const MotionLobe& lobe : stretch.lobes) {
      stretch.corners.push_back(corners_of(rows_, lobe));
      farthest_m = std::max(farthest_m, std::abs(lobe.displacement_m));
    }
    const MotionLobe &first = stretch.lobes.front(), &last = stretch.lobes.back();
    stretch.open_begin = moves_at_begin && first.begin == begin;
    stretch.open_end = moves_at_end && last.end == end;
    stretch.window_begin_s = stretch.open_begin ? rows_.t_s(begin) : rows_.rest_begin_s(first.begin);
    stretch.window_end_s = stretch.open_end ? rows_.t_s(end - 1) + 0.5 * rows_.period_s()
                                            : rows_.tail_end_s(last.end, least_lobe_share * farthest_m,
                                                               1e-6 * static_cast<double>(longest_ringing.count()));
    stretch.whole = stretch.corners.back().end_s - stretch.corners.front().start_s <= longest_fit_s &&
                    stretch.lobes.size() <= most_lobes_fitted;
    return stretch;
  }

  /// Sets the fits. One that has moved far from the seen start or end is left out.
  void fit(Stretch& stretch) const {
    const LobeCorners &first = stretch.corners.front(), &last = stretch.corners.back();
    if (stretch.whole) {
      std::vector<double> peaked = knots_of(stretch, true), flat = knots_of(stretch, false);
      if (flat == peaked) flat.clear();
      stretch.start_fit = stretch.end_fit = fitted(stretch.window_begin_s, stretch.window_end_s, std::move(peaked),
                                                   std::move(flat), stretch.open_begin, stretch.open_end);
    } else {
      if (!stretch.open_begin) {
        const double until_s = std::min(first.up_s + edge_s, std::max(first.down_s, first.up_s + 4.0 * rows_.period_s()));
        stretch.start_fit = fitted(stretch.window_begin_s, until_s, {first.start_s, first.up_s, until_s}, {}, false, true);
      }
      if (!stretch.open_end) {
        const double since_s = std::max(last.down_s - edge_s, std::min(last.up_s, last.down_s - 4.0 * rows_.period_s()));
        stretch.end_fit = fitted(since_s, stretch.window_end_s, {since_s, last.down_s, last.end_s}, {}, true, false);
      }
    }
    const auto is_far = [](double fitted_s, double seen_s) { return std::abs(fitted_s - seen_s) >= farthest_s; };
    if (stretch.start_fit && !stretch.open_begin && is_far(stretch.start_fit->knots_s.front(), first.start_s))
      stretch.start_fit.reset();
    if (stretch.end_fit && !stretch.open_end && is_far(stretch.end_fit->knots_s.back(), last.end_s)) stretch.end_fit.reset();
    if (stretch.whole && (!stretch.start_fit || !stretch.end_fit)) {
      stretch.start_fit.reset();
      stretch.end_fit.reset();
    }
  }

  /// Rough knots of the whole stretch. A short height has one knot, or two where it may be no peak.
  std::vector<double> knots_of(const Stretch& stretch, bool may_be_peak) const {
    std::vector<double> knots;
    const std::vector<LobeCorners>& corners = stretch.corners;
    add_knot(knots, stretch.open_begin ? stretch.window_begin_s : std::max(corners.front().start_s, stretch.window_begin_s));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const LobeCorners& one = corners[i];
      if (i > 0 && one.start_s - corners[i - 1].end_s > least_dwell_s_) {
        add_knot(knots, corners[i - 1].end_s);
        add_knot(knots, one.start_s);
      }
      const double ramps_s = one.up_s - one.start_s + one.end_s - one.down_s;
      const double least_s = std::max({0.02, 2.0 * rows_.period_s(), may_be_peak ? peak_share * ramps_s : 0.0});
      if (one.down_s - one.up_s < least_s) {
        add_knot(knots, 0.5 * (one.up_s + one.down_s));
      } else {
        add_knot(knots, one.up_s);
        add_knot(knots, one.down_s);
      }
    }
    add_knot(knots, stretch.open_end ? stretch.window_end_s : corners.back().end_s);
    return knots;
  }

  std::optional<SpeedProfile> fitted(double from_s, double to_s, std::vector<double> knots, std::vector<double> other_knots,
                                     bool open_begin, bool open_end) const {
    const std::size_t begin = rows_.row_at_or_after(from_s), end = rows_.row_at_or_after(to_s);
    if (end <= begin) return std::nullopt;
    std::vector<SpeedRow> rows;
    const std::size_t stride = (end - begin + most_rows_fitted - 1) / most_rows_fitted;
    for (std::size_t i = begin; i < end; i += stride) rows.push_back(rows_.rows()[i]);
    return fit_speed_profile(rows, {.noise = rows_.noise(),
                                    .smoothed_s = 1e-6 * static_cast<double>(log_.smoothed_over.count()),
                                    .knots_s = std::move(knots),
                                    .other_knots_s = std::move(other_knots),
                                    .open_begin = open_begin,
                                    .open_end = open_end,
                                    .ringing = ringing_});
  }

  void set_ends(Stretch& stretch) const {
    UncertainSeconds start{rows_.t_s(stretch.begin), infinite}, stop{rows_.t_s(stretch.end - 1), infinite};
    if (!stretch.open_begin) {
      const auto& found = stretch.start_fit;
      start = found ? UncertainSeconds{found->knots_s.front(), found->sigma_s(0)} : lobe_edge(rows_, stretch.lobes.front(), true);
    }
    if (!stretch.open_end) {
      const auto& found = stretch.end_fit;
      stop = found ? UncertainSeconds{found->knots_s.back(), found->sigma_s(found->knots_s.size() - 1)}
                   : lobe_edge(rows_, stretch.lobes.back(), false);
    }
    if (!(stop.t_s > start.t_s)) {
      start.t_s = rows_.t_s(stretch.begin);
      stop.t_s = std::max(rows_.t_s(stretch.end - 1), start.t_s + rows_.period_s());
    }
    stretch.start = start;
    stretch.stop = stop;
  }

  void add_phases(const Stretch& stretch) {
    UncertainSeconds from = stretch.start;
    for (std::size_t i = 0; i < stretch.lobes.size(); ++i) {
      UncertainSeconds until = stretch.stop, next = stretch.stop;
      if (i + 1 < stretch.lobes.size()) std::tie(until, next) = between(stretch, stretch.lobes[i], stretch.lobes[i + 1]);
      until.t_s = std::clamp(until.t_s, from.t_s, stretch.stop.t_s);
      next.t_s = std::clamp(next.t_s, until.t_s, stretch.stop.t_s);
      add_phase(stretch, stretch.lobes[i], from, until);
      from = next;
    }
  }

  /// The end of a lobe and the start of the next: one time, or two if the arm rests in between.
  std::pair<UncertainSeconds, UncertainSeconds> between(const Stretch& stretch, const MotionLobe& before,
                                                        const MotionLobe& after) const {
    const double from_s = rows_.t_s(before.end - 1), to_s = rows_.t_s(after.begin);
    const UncertainSeconds seen{0.5 * (from_s + to_s), std::max(0.5 * (to_s - from_s), 0.5 * rows_.period_s())};
    if (!stretch.whole || !stretch.start_fit) {
      if (to_s - from_s > least_dwell_s_) return {lobe_edge(rows_, before, false), lobe_edge(rows_, after, true)};
      return {seen, seen};
    }
    // The commanded speed between the two heights: where it passes through zero, or rests there.
    const SpeedProfile& profile = *stretch.start_fit;
    const bool turns = (before.displacement_m < 0) != (after.displacement_m < 0);
    const double slow = std::max(rows_.limit(), 3.0 * profile.speed_sigma);
    const std::size_t knots = profile.knots_s.size();
    std::optional<std::size_t> rests;
    for (std::size_t k = 1; k < knots; ++k) {
      const double a = dot(profile.speeds[k - 1], stretch.direction), b = dot(profile.speeds[k], stretch.direction);
      const double t = profile.knots_s[k - 1], u = profile.knots_s[k];
      if (u < from_s - 0.05 || t > to_s + 0.05) continue;
      if (k > 1 && k + 1 < knots && std::abs(a) < slow && std::abs(b) < slow && u - t > 0.5 * least_dwell_s_) rests = k;
      if (turns && a * b < 0 && !rests) {
        const double share = a / (a - b), gradient = std::abs(b - a) / (u - t);
        const double rows = std::max(1.0, (u - t) / rows_.period_s());
        const UncertainSeconds zero{t + share * (u - t), 1.5 * profile.speed_sigma / gradient / std::sqrt(rows)};
        return {zero, zero};
      }
    }
    if (!rests) return {seen, seen};
    return {{profile.knots_s[*rests - 1], profile.sigma_s(*rests - 1)}, {profile.knots_s[*rests], profile.sigma_s(*rests)}};
  }

  RobotTime time_at(double t_s) const { return log_.states.front().t + microseconds{std::llround(1e6 * t_s)}; }

  void add_phase(const Stretch& stretch, const MotionLobe& lobe, const UncertainSeconds& start, const UncertainSeconds& end) {
    MotionPhase phase;
    phase.start = time_at(start.t_s);
    phase.end = time_at(end.t_s);
    phase.start_sigma_us = std::hypot(1e6 * start.sigma_s, time_sigma_us);
    phase.end_sigma_us = std::hypot(1e6 * end.sigma_s, time_sigma_us);
    const std::optional<SpeedProfile>& profile = stretch.any_fit();
    for (std::size_t k = 0; profile && stretch.whole && k < profile->knots_s.size(); ++k) {
      if (profile->knots_s[k] >= start.t_s && profile->knots_s[k] <= end.t_s)
        phase.peak_speed = std::max(phase.peak_speed, length_of(profile->speeds[k]));
    }
    if (phase.peak_speed == 0) phase.peak_speed = corners_of(rows_, lobe).height;
    phase.profile = stretch.profile();
    if (phase.profile) phase.profile = shifted(*std::move(phase.profile), -start.t_s);

    std::size_t first = std::min(rows_.row_at_or_after(start.t_s), rows_.size() - 1);
    std::size_t last = std::min(rows_.row_at_or_after(end.t_s), rows_.size() - 1);
    if (first > 0 && !rows_.gap_before(first)) --first;
    if (last > 0 && rows_.gap_before(last) && rows_.t_s(last) > end.t_s) --last;
    const robot::RobotState &before = log_.states[std::min(first, last)], &after = log_.states[last];
    for (std::size_t a = 0; a < 3; ++a) phase.displacement[a] = after.tcp_pose[a] - before.tcp_pose[a];
    phase.height_change = phase.displacement[2];
    const double upright = std::sqrt(0.5) * length_of(phase.displacement);
    phase.kind = phase.height_change > 0 && phase.height_change >= upright    ? MotionKind::lift
                 : phase.height_change < 0 && -phase.height_change >= upright ? MotionKind::lower
                                                                              : MotionKind::sideways;
    phases_.push_back(std::move(phase));
  }

  std::vector<MotionPhase> join_taps() const {
    std::vector<MotionPhase> joined;
    for (const MotionPhase& phase : phases_) {
      if (!joined.empty() && returns(joined.back(), phase)) {
        join(joined.back(), phase);
      } else {
        joined.push_back(phase);
      }
    }
    return joined;
  }

  /// Whether `back` returns to where `there` began, so that the two are a tap.
  bool returns(const MotionPhase& there, const MotionPhase& back) const {
    if (there.kind == MotionKind::tap || there.kind == MotionKind::lift) return false;
    if (back.start - there.end > microseconds{std::llround(1e6 * longest_dwell_s)}) return false;
    if (back.end - there.start > options_.longest_tap) return false;
    Vector3 left = there.displacement;
    for (std::size_t a = 0; a < 3; ++a) left[a] += back.displacement[a];
    return length_of(left) <= 0.2 * length_of(there.displacement);
  }

  static void join(MotionPhase& tap, const MotionPhase& back) {
    tap.kind = MotionKind::tap;
    tap.turn = tap.end + (back.start - tap.end) / 2;
    tap.turn_sigma_us =
        std::hypot(std::max(tap.end_sigma_us, back.start_sigma_us), static_cast<double>((back.start - tap.end).count()) / 4.0);
    tap.end = back.end;
    tap.end_sigma_us = back.end_sigma_us;
    tap.peak_speed = std::max(tap.peak_speed, back.peak_speed);
    for (std::size_t a = 0; a < 3; ++a) tap.displacement[a] += back.displacement[a];
    tap.height_change += back.height_change;
    if (!tap.profile || !back.profile) {
      tap.profile.reset();
      return;
    }
    const SpeedProfile later = shifted(*back.profile, 1e-6 * static_cast<double>((back.start - tap.start).count()));
    // Of one stretch both have the same profile.
    if (later.knots_s.front() > tap.profile->knots_s.back()) tap.profile->append(later);
  }

  const robot::RobotLog& log_;
  const MotionPhaseOptions& options_;
  MotionRows rows_;
  double least_dwell_s_;
  std::optional<ArmRinging> ringing_;  ///< of the last motion
  std::vector<MotionPhase> phases_;
};

}  // namespace

std::string_view name_of(MotionKind kind) {
  constexpr std::array<std::string_view, 4> names{"lift", "lower", "sideways", "tap"};
  return names.at(static_cast<std::size_t>(kind));
}

bool MotionPhase::is_whole() const { return std::isfinite(start_sigma_us) && std::isfinite(end_sigma_us); }

std::vector<MotionPhase> motion_phases(const robot::RobotLog& log, const MotionPhaseOptions& options) {
  return log.states.empty() ? std::vector<MotionPhase>() : PhaseFinder(log, options).phases();
}

}  // namespace tactile::alignment
