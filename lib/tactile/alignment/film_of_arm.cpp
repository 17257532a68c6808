#include "tactile/alignment/film_of_arm.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/alignment/film_motions.hpp"

namespace tactile::alignment {
namespace {

constexpr double least_likeness = 0.8;   // correlation of energy and speed at the best offset
constexpr double least_ambiguity = 1.5;  // best likeness over that of the next best offset
constexpr double most_disagreement_us = 60'000;

std::vector<FilmStep> steps_of(const MotionEnergy& energy) {
  std::vector<FilmStep> steps;
  for (const MotionStep& step : energy.steps) {
    steps.push_back({static_cast<double>((step.begin - energy.begin()).count()),
                     static_cast<double>((step.end - energy.begin()).count()), step.energy});
  }
  return steps;
}

/// Neighbours joined, so that no more than `most` steps are left.
std::vector<FilmStep> fewer_steps(const std::vector<FilmStep>& steps, std::size_t most) {
  const std::size_t together = (steps.size() + most - 1) / most;
  if (together <= 1) return steps;
  std::vector<FilmStep> fewer;
  for (std::size_t i = 0; i < steps.size(); i += together) {
    FilmStep sum{steps[i].begin, steps[i].begin, 0};
    double length = 0;
    for (std::size_t j = i; j < std::min(i + together, steps.size()); ++j) {
      sum.end = steps[j].end;
      sum.energy += steps[j].energy * steps[j].length();
      length += steps[j].length();
    }
    sum.energy /= length;
    fewer.push_back(sum);
  }
  return fewer;
}

/// The seen speed and its integral, in microseconds from its first value.
class SpeedCurve {
 public:
  explicit SpeedCurve(const SeenMotion& seen) : step_(static_cast<double>(seen.step.count())), values_(seen.speed) {
    integrals_.push_back(0);
    for (std::size_t i = 0; i + 1 < values_.size(); ++i)
      integrals_.push_back(integrals_[i] + 0.5 * step_ * (values_[i] + values_[i + 1]));
    for (const double value : values_) {
      peak_ = std::max(peak_, value);
      power_ += step_ * value * value;
    }
  }

  double length() const { return step_ * static_cast<double>(values_.size() - 1); }
  double peak() const { return peak_; }
  double power() const { return power_; }  ///< the integral of its square
  bool holds(double begin, double end) const { return begin >= 0 && end <= length(); }
  double mean(double begin, double end) const { return (integral(end) - integral(begin)) / (end - begin); }

  const std::vector<double>& values() const { return values_; }
  double step() const { return step_; }

 private:
  double integral(double t) const {
    const double place = std::clamp(t / step_, 0.0, static_cast<double>(values_.size() - 1));
    const std::size_t i = std::min(static_cast<std::size_t>(place), values_.size() - 2);
    const double u = place - static_cast<double>(i);
    return integrals_[i] + step_ * u * (values_[i] + 0.5 * u * (values_[i + 1] - values_[i]));
  }

  double step_;
  std::vector<double> values_, integrals_;
  double peak_ = 0, power_ = 0;
};

/// Weighted sums of the energies e of steps and the speeds v during them.
struct StepSums {
  double n = 0, w = 0, e = 0, v = 0, ee = 0, vv = 0, ev = 0;

  void add(const FilmStep& step, double speed, double weight) {
    n += 1;
    w += weight;
    e += weight * step.energy;
    v += weight * speed;
    ee += weight * step.energy * step.energy;
    vv += weight * speed * speed;
    ev += weight * step.energy * speed;
  }
  double energy_spread() const { return w * ee - e * e; }
  double speed_spread() const { return w * vv - v * v; }
  double product() const { return w * ev - e * v; }
};

/// How well energy and speed match at an offset: a time of the film + offset is a time of the speed.
struct Likeness {
  double correlation = -1;  ///< over what they share, -1 to 1
  double score = -1;        ///< the same, lower where much of either lies beyond the other's end
};

Likeness likeness(const std::vector<FilmStep>& steps, const SpeedCurve& speed, double offset) {
  constexpr int fewest_steps = 6;
  StepSums sums;
  double whole_ee = 0;
  for (const FilmStep& step : steps) {
    const double begin = step.begin + offset, end = step.end + offset, w = step.length();
    whole_ee += w * step.energy * step.energy;
    if (speed.holds(begin, end)) sums.add(step, speed.mean(begin, end), w);
  }
  const double spread = sums.energy_spread() * sums.speed_spread();
  if (sums.n < fewest_steps || !(spread > 0)) return {};
  const double correlation = sums.product() / std::sqrt(spread);
  return {correlation, correlation * std::sqrt(std::min(1.0, sums.vv / speed.power()) * (sums.ee / whole_ee))};
}

struct Match {
  double offset = 0;
  Likeness found;
  double second = 0;  ///< the best score of another peak
};

/// The best offset on a grid.
Match coarse_match(const std::vector<FilmStep>& steps, const SpeedCurve& speed, double from, double to, double grid) {
  std::vector<double> found;
  for (int i = 0; from + grid * i <= to; ++i) found.push_back(likeness(steps, speed, from + grid * i).score);
  if (found.empty()) return {};
  const auto best = std::max_element(found.begin(), found.end());
  // The peak reaches to where half of it is left.
  auto left = best, right = best;
  while (left != found.begin() && *left > 0.5 * *best) --left;
  while (right + 1 != found.end() && *right > 0.5 * *best) ++right;
  double second = 0;
  for (auto other = found.begin(); other != found.end(); ++other) {
    const bool is_peak =
        (other == found.begin() || *(other - 1) <= *other) && (other + 1 == found.end() || *(other + 1) <= *other);
    if ((other < left || other > right) && is_peak) second = std::max(second, *other);
  }
  const double offset = from + grid * static_cast<double>(best - found.begin());
  return {offset, likeness(steps, speed, offset), second};
}

/// Where a function that is known at -1, 0, 1 has its extreme, by a parabola: -1 to 1.
double extreme_of(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature == 0 ? 0.0 : std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0);
}

Match fine_match(const std::vector<FilmStep>& steps, const SpeedCurve& speed, const Match& coarse, double grid) {
  constexpr double finest = 1'000;
  Match match = coarse;
  double reach = grid;
  while (reach > finest) {
    const double fine = std::max(reach / 16, finest), around = match.offset;
    for (int i = 0; fine * i <= 2 * reach; ++i) {
      const double offset = around - reach + fine * i;
      const Likeness found = likeness(steps, speed, offset);
      if (found.score <= match.found.score) continue;
      match.found = found;
      match.offset = offset;
    }
    if (fine <= finest) break;
    reach = 2 * fine;
  }
  const auto at = [&](double offset) { return likeness(steps, speed, offset).score; };
  match.offset += finest * extreme_of(at(match.offset - finest), at(match.offset), at(match.offset + finest));
  return match;
}

/// Where the speed rises from rest, or falls to it: from a twentieth of the greatest speed to nine tenths of the motion's.
struct Ramp {
  double rest = 0, full = 0;  ///< times [us] from the speed's first value; rest > full where it falls

  double middle() const { return 0.5 * (rest + full); }
};

/// A motion, with as much of it as is known.
struct Motion {
  std::optional<Ramp> start, stop;
};

/// Every motion that reaches a third of the greatest speed.
std::vector<Motion> motions_in(const SpeedCurve& speed) {
  constexpr double moving = 0.05, reached = 0.9, least_peak = 0.33;
  const std::vector<double>& v = speed.values();
  const double limit = moving * speed.peak();
  const auto time = [&](std::size_t i) { return speed.step() * static_cast<double>(i); };
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < v.size();) {
    if (v[i] < limit) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    double peak = 0;
    for (; i < v.size() && v[i] >= limit; ++i) peak = std::max(peak, v[i]);
    if (peak < least_peak * speed.peak()) continue;
    std::size_t rise = begin, fall = i - 1;
    while (v[rise] < reached * peak) ++rise;
    while (v[fall] < reached * peak) --fall;
    Motion motion;
    if (begin > 0) motion.start = Ramp{time(begin), time(rise)};
    if (i < v.size()) motion.stop = Ramp{time(i - 1), time(fall)};
    motions.push_back(motion);
  }
  return motions;
}

/// The sum of squares that the best energy = a speed + c, a > 0, leaves; infinite where there is none.
double amplitude_misfit(std::span<const FilmStep> steps, const SpeedCurve& speed, double offset) {
  constexpr double none = std::numeric_limits<double>::infinity();
  StepSums sums;
  for (const FilmStep& step : steps) {
    const double begin = step.begin + offset, end = step.end + offset;
    if (!speed.holds(begin, end)) return none;
    sums.add(step, speed.mean(begin, end), 1.0);
  }
  const double spread = sums.speed_spread();
  if (!(spread > 0) || sums.product() <= 0) return none;
  const double amplitude = sums.product() / spread;
  return std::max(sums.ee - sums.e * sums.e / sums.n - amplitude * amplitude * spread / sums.n, 0.0);
}

/// The steps around a ramp: a few frames at rest and a few at speed. None where frames lack.
std::span<const FilmStep> steps_near(const std::vector<FilmStep>& steps, const Ramp& ramp, double offset, double frame) {
  constexpr std::size_t fewest = 6;
  const double margin = 4 * frame;
  const double begin = std::min(ramp.rest, ramp.full) - margin - offset, end = std::max(ramp.rest, ramp.full) + margin - offset;
  const auto first = std::lower_bound(steps.begin(), steps.end(), begin, [](const FilmStep& s, double t) { return s.begin < t; });
  auto last = first;
  while (last != steps.end() && last->end <= end) ++last;
  const std::span<const FilmStep> near(first, last);
  for (std::size_t i = 0; i + 1 < near.size(); ++i) {
    if (near[i + 1].begin - near[i].end > frame) return {};
  }
  return near.size() < fewest ? std::span<const FilmStep>() : near;
}

/// The offset at which the film's steps fit a ramp best, and its standard deviation.
struct OffsetFit {
  double offset = 0, sigma = 0;
};

std::optional<OffsetFit> fit_offset(const std::vector<FilmStep>& steps, const SpeedCurve& speed, const Ramp& ramp, double offset,
                                    double frame) {
  constexpr int parameters = 3;
  const double reach = 2.5 * frame, grid = std::min(1'000.0, frame / 16);
  const std::span<const FilmStep> near = steps_near(steps, ramp, offset, frame);
  if (near.empty()) return std::nullopt;
  std::vector<double> left;
  std::size_t best = 0;
  const auto count = static_cast<std::size_t>(2 * reach / grid) + 1;
  const auto offset_at = [&](std::size_t i) { return offset - reach + grid * static_cast<double>(i); };
  for (std::size_t i = 0; i < count; ++i) {
    left.push_back(amplitude_misfit(near, speed, offset_at(i)));
    if (left[i] < left[best]) best = i;
  }
  if (best == 0 || best + 1 == count || !std::isfinite(left[best])) return std::nullopt;
  // The curvature over half a frame either way: from one frame to the next the sum is no smooth parabola.
  const auto wide = std::max<std::size_t>(1, static_cast<std::size_t>(0.25 * frame / grid));
  if (best < wide || best + wide >= count || !std::isfinite(left[best - wide]) || !std::isfinite(left[best + wide]))
    return std::nullopt;
  const double width = grid * static_cast<double>(wide);
  const double curvature = (left[best - wide] - 2 * left[best] + left[best + wide]) / (width * width);
  if (!(curvature > 0)) return std::nullopt;
  const double variance = left[best] / std::max(1, static_cast<int>(near.size()) - parameters);
  return OffsetFit{offset_at(best) + grid * extreme_of(left[best - 1], left[best], left[best + 1]),
                   std::sqrt(2 * variance / curvature)};
}

/// The offset at which the film shows a motion.
struct MotionFit {
  double speed_time = 0;  ///< of the motion [us] from the speed's first value
  double offset = 0, sigma = 0;
  double apart = 0;  ///< of the offsets of start and stop
};

std::optional<MotionFit> fit_motion(const std::vector<FilmStep>& steps, const SpeedCurve& speed, const Motion& motion,
                                    double offset, double frame) {
  const auto fitted = [&](const std::optional<Ramp>& ramp) {
    return ramp ? fit_offset(steps, speed, *ramp, offset, frame) : std::nullopt;
  };
  const std::optional<OffsetFit> start = fitted(motion.start), stop = fitted(motion.stop);
  if (start && stop) {
    const double half = 0.5 * (start->offset - stop->offset), usual = frame / 32;
    const double misfit = (half * half + 2 * usual * usual) / 3;
    return MotionFit{.speed_time = 0.5 * (motion.start->middle() + motion.stop->middle()),
                     .offset = 0.5 * (start->offset + stop->offset),
                     .sigma = std::sqrt(0.25 * (start->sigma * start->sigma + stop->sigma * stop->sigma) + misfit),
                     .apart = 2 * std::abs(half)};
  }
  if (!start && !stop) return std::nullopt;
  const OffsetFit& only = start ? *start : *stop;
  return MotionFit{.speed_time = (start ? *motion.start : *motion.stop).middle(),
                   .offset = only.offset,
                   .sigma = std::hypot(only.sigma, frame / 16)};
}

/// Why film and speed cannot be compared; empty if they can.
std::string refusal_of(const std::vector<FilmStep>& steps, const SeenMotion& seen) {
  constexpr std::size_t fewest_steps = 8;
  if (steps.size() < fewest_steps)
    return fmt::format("the film has {} steps from frame to frame; expected at least {}", steps.size(), fewest_steps);
  if (seen.speed.size() < 2 || seen.step.count() <= 0) return "nothing is known of the motion that the film should show";
  if (std::none_of(seen.speed.begin(), seen.speed.end(), [](double v) { return v > 0; }))
    return "nothing moves that the film should show";
  if (std::none_of(steps.begin(), steps.end(), [](const FilmStep& step) { return step.energy > 0; }))
    return "nothing moves in the film";
  return {};
}

/// Sets the ratio of the best to the second-best score. @return why it is refused; empty if it is not
std::string set_ambiguity(VideoClockFit& fit, double best, double second) {
  constexpr double no_other = 99;
  fit.ambiguity = second > 0 ? std::min(best / second, no_other) : no_other;
  if (fit.ambiguity >= least_ambiguity) return {};
  return fmt::format("the film matches at two offsets: the better is only {:.2f} times as good; expected {:.2f}", fit.ambiguity,
                     least_ambiguity);
}

/// A film and the speed it should have seen. Offsets are those of the speed's start against the film's.
class ArmMatch {
 public:
  ArmMatch(const MotionEnergy& energy, const SeenMotion& seen, std::vector<FilmStep> steps)
      : energy_(energy),
        seen_(seen),
        steps_(std::move(steps)),
        speed_(seen),
        frame_(static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1))) {}

  /// Sets likeness and ambiguity. @return why the match is refused; empty if it is not
  std::string match(VideoClockFit& fit) {
    constexpr std::size_t most_steps = 2048;
    const double film_us = steps_.back().end;
    double from = -film_us, to = speed_.length();
    std::int64_t apart_us = 0;
    if (__builtin_sub_overflow(us_of(seen_.begin), us_of(energy_.begin()), &apart_us))
      return "the two clocks lie further apart than 64 bits of microseconds";
    const std::vector<FilmStep> fewer = fewer_steps(steps_, most_steps);
    const double grid = std::max(0.5 * frame_, (film_us + speed_.length()) / (4.0 * most_steps));
    const Match found = fine_match(steps_, speed_, coarse_match(fewer, speed_, from, to, grid), grid);
    offset_ = found.offset;
    fit.likeness = found.found.correlation;
    std::string ambiguous = set_ambiguity(fit, found.found.score, found.second);
    if (fit.likeness >= least_likeness) return ambiguous;
    return fmt::format("the motion in the film does not match the arm's: their correlation is at most {:.2f}; expected {:.2f}",
                       std::max(fit.likeness, 0.0), least_likeness);
  }

  /// Adds an anchor per motion. @return why they are refused; empty if they are not
  std::string add_anchors(VideoClockFit& fit) const {
    std::vector<MotionFit> motions;
    double apart = 0;
    for (const Motion& motion : motions_in(speed_)) {
      const std::optional<MotionFit> found = fit_motion(steps_, speed_, motion, offset_, frame_);
      if (!found) continue;
      motions.push_back(*found);
      apart = std::max(apart, found->apart);
    }
    if (motions.empty()) return "the film shows neither start nor stop of the arm's motion";
    if (apart > most_disagreement_us) {
      fit.contradiction =
          doubt("film-unlike-arm",
                "a motion in the film and the arm's in the robot log differ by {:.0f} ms in length: one of the two "
                "may be of another recording, or the film lacks frames",
                1e-3 * apart);
      return fit.contradiction.words;
    }
    for (const MotionFit& motion : motions) {
      const std::int64_t at_us = std::llround(motion.speed_time);
      fit.anchors.push_back({.clock_us = saturating_add(us_of(energy_.begin()), at_us - std::llround(motion.offset)),
                             .camera = after(seen_.begin, microseconds{at_us}),
                             .sigma_us = motion.sigma,
                             .bias_us = seen_.sigma_us});
    }
    return {};
  }

 private:
  const MotionEnergy& energy_;
  const SeenMotion& seen_;
  std::vector<FilmStep> steps_;
  SpeedCurve speed_;
  double frame_, offset_ = 0;
};

}  // namespace

SeenMotion seen_motion(const ArmMotion& arm, std::span<const CameraSpan> moves, const FittedClock& robot_clock) {
  constexpr microseconds longest_ringing = 350ms;
  SeenMotion seen;
  const std::size_t n = arm.velocity.size();
  if (n < 2) return seen;
  const ClockRelation& clock = robot_clock.relation;
  seen.begin = clock.camera_from(arm.begin);
  seen.step = arm.step;
  seen.sigma_us =
      0.5 / normal_95 * static_cast<double>(saturating_subtract(robot_clock.offset_high_us, robot_clock.offset_low_us));
  const CameraTime end = clock.camera_from(arm.time_of(n - 1));
  const auto step_us = static_cast<double>(arm.step.count());
  for (CameraTime t = seen.begin; t <= end && seen.speed.size() < n + n / 1000; t = after(t, seen.step)) {
    const double place = static_cast<double>(saturating_subtract(clock.clock_us_from(t), us_of(arm.begin))) / step_us;
    const std::size_t i = std::min(static_cast<std::size_t>(std::max(place, 0.0)), n - 2);
    const double share = std::clamp(place - static_cast<double>(i), 0.0, 1.0);
    const bool moves_now = std::any_of(moves.begin(), moves.end(), [&](const CameraSpan& move) {
      return t >= move.begin && t < after(move.end, longest_ringing);
    });
    const double from = length_of(arm.velocity[i]), to = length_of(arm.velocity[i + 1]);
    seen.speed.push_back(moves_now && arm.known[i] ? from + share * (to - from) : 0.0);
  }
  return seen;
}

VideoClockFit fit_video_clock(const MotionEnergy& energy, const SeenMotion& seen) {
  VideoClockFit fit;
  std::vector<FilmStep> steps = steps_of(energy);
  fit.refused = refusal_of(steps, seen);
  if (!fit.refused.empty()) return fit;
  ArmMatch match(energy, seen, std::move(steps));
  fit.refused = match.match(fit);
  if (fit.refused.empty()) fit.refused = match.add_anchors(fit);
  return fit.refused.empty() ? with_clock(std::move(fit), energy) : fit;
}

}  // namespace tactile::alignment
