#include "tactile/labels/video_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/core/robust_statistics.hpp"

namespace tactile {
namespace {

constexpr double normal_95 = 1.96;
constexpr double no_other = 99;

/// A step of the film, in microseconds from its first frame.
struct Step {
  double begin = 0, end = 0, energy = 0;

  double length() const { return end - begin; }
};

std::vector<Step> steps_of(const MotionEnergy& energy) {
  std::vector<Step> steps;
  for (const MotionStep& step : energy.steps) {
    steps.push_back({static_cast<double>((step.begin - energy.begin()).count()),
                     static_cast<double>((step.end - energy.begin()).count()), step.energy});
  }
  return steps;
}

/// Neighbours put together, so that no more than so many are left.
std::vector<Step> fewer_steps(const std::vector<Step>& steps, std::size_t most) {
  const std::size_t together = (steps.size() + most - 1) / most;
  if (together <= 1) return steps;
  std::vector<Step> fewer;
  for (std::size_t i = 0; i < steps.size(); i += together) {
    Step sum{steps[i].begin, steps[i].begin, 0};
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
class Speed {
 public:
  explicit Speed(const SeenMotion& seen) : step_(static_cast<double>(seen.step.count())), values_(seen.speed) {
    ways_.push_back(0);
    for (std::size_t i = 0; i + 1 < values_.size(); ++i) ways_.push_back(ways_[i] + 0.5 * step_ * (values_[i] + values_[i + 1]));
    for (const double value : values_) peak_ = std::max(peak_, value);
  }

  double length() const { return step_ * static_cast<double>(values_.size() - 1); }
  double peak() const { return peak_; }
  bool knows(double begin, double end) const { return begin >= 0 && end <= length(); }
  double mean(double begin, double end) const { return (way(end) - way(begin)) / (end - begin); }

  const std::vector<double>& values() const { return values_; }
  double step() const { return step_; }

  /// The integral of its square.
  double power() const {
    double sum = 0;
    for (const double value : values_) sum += step_ * value * value;
    return sum;
  }

 private:
  double way(double t) const {
    const double place = std::clamp(t / step_, 0.0, static_cast<double>(values_.size() - 1));
    const std::size_t i = std::min(static_cast<std::size_t>(place), values_.size() - 2);
    const double u = place - static_cast<double>(i);
    return ways_[i] + step_ * u * (values_[i] + 0.5 * u * (values_[i + 1] - values_[i]));
  }

  double step_;
  std::vector<double> values_, ways_;
  double peak_ = 0;
};

/// How alike they are if a time of the film is so much less than that of the speed.
struct Likeness {
  double correlation = -1;  ///< over what they share, -1 to 1
  double score = -1;        ///< that, less where much of the film's energy, or of the speed, lies beyond the other's end
};

Likeness likeness(const std::vector<Step>& steps, const Speed& speed, double whole_power, double offset) {
  constexpr int fewest_steps = 6;
  double n = 0, w_sum = 0, e_sum = 0, v_sum = 0, ee = 0, vv = 0, ev = 0, whole_ee = 0;
  for (const Step& step : steps) {
    const double begin = step.begin + offset, end = step.end + offset, w = step.length(), e = step.energy;
    whole_ee += w * e * e;
    if (!speed.knows(begin, end)) continue;
    const double v = speed.mean(begin, end);
    n += 1;
    w_sum += w;
    e_sum += w * e;
    v_sum += w * v;
    ee += w * e * e;
    vv += w * v * v;
    ev += w * e * v;
  }
  const double spread = (w_sum * ee - e_sum * e_sum) * (w_sum * vv - v_sum * v_sum);
  if (n < fewest_steps || !(spread > 0)) return {};
  const double correlation = (w_sum * ev - e_sum * v_sum) / std::sqrt(spread);
  return {correlation, correlation * std::sqrt(std::min(1.0, vv / whole_power) * (ee / whole_ee))};
}

struct Match {
  double offset = 0;
  Likeness found;
  double second = 0;  ///< the best score that is not of the same peak
};

/// The best place on a grid.
Match coarse_match(const std::vector<Step>& steps, const Speed& speed, double from, double to, double grid) {
  const double whole_power = speed.power();
  std::vector<double> found;
  for (double offset = from; offset <= to; offset += grid) found.push_back(likeness(steps, speed, whole_power, offset).score);
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
  return {offset, likeness(steps, speed, whole_power, offset), second};
}

/// Where a function that is known at -1, 0, 1 has its extreme, by a parabola: -1 to 1.
double extreme_of(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend == 0 ? 0.0 : std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
}

Match fine_match(const std::vector<Step>& steps, const Speed& speed, const Match& coarse, double grid) {
  const double whole_power = speed.power();
  Match match = coarse;
  double reach = grid;
  while (reach > 1'000) {
    const double fine = std::max(reach / 16, 1'000.0), around = match.offset;
    for (double offset = around - reach; offset <= around + reach; offset += fine) {
      const Likeness found = likeness(steps, speed, whole_power, offset);
      if (found.score > match.found.score) {
        match.found = found;
        match.offset = offset;
      }
    }
    if (fine <= 1'000) break;
    reach = 2 * fine;
  }
  const auto at = [&](double offset) { return likeness(steps, speed, whole_power, offset).score; };
  match.offset += 1'000 * extreme_of(at(match.offset - 1'000), at(match.offset), at(match.offset + 1'000));
  return match;
}

/// Where the speed rises from rest, or falls to it: from a twentieth of the greatest to nine tenths of what it reaches.
struct Ramp {
  double rest = 0, full = 0;  ///< times [us] from the speed's first value; rest > full where it falls

  double middle() const { return 0.5 * (rest + full); }
};

/// A motion, with as much of it as is known.
struct Motion {
  std::optional<Ramp> start, stop;
};

/// Every motion that reaches a third of the greatest speed.
std::vector<Motion> motions_in(const Speed& speed) {
  constexpr double moving = 0.05, reached = 0.9, worth_it = 0.33;
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
    if (peak < worth_it * speed.peak()) continue;
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

/// A least-squares fit of energy = a speed + c.
struct AmplitudeFit {
  double amplitude = 0;
  double left = std::numeric_limits<double>::infinity();  ///< sum of squares that it does not explain
  int steps = 0;
};

AmplitudeFit fit_amplitude(std::span<const Step> steps, const Speed& speed, double offset) {
  double n = 0, e_sum = 0, v_sum = 0, ee = 0, vv = 0, ev = 0;
  for (const Step& step : steps) {
    const double begin = step.begin + offset, end = step.end + offset;
    if (!speed.knows(begin, end)) return {};
    const double v = speed.mean(begin, end);
    n += 1;
    e_sum += step.energy;
    v_sum += v;
    ee += step.energy * step.energy;
    vv += v * v;
    ev += step.energy * v;
  }
  const double spread = n * vv - v_sum * v_sum;
  if (!(spread > 0)) return {};
  const double amplitude = (n * ev - e_sum * v_sum) / spread;
  if (amplitude <= 0) return {};
  const double left = ee - e_sum * e_sum / n - amplitude * amplitude * spread / n;
  return {amplitude, std::max(left, 0.0), static_cast<int>(n)};
}

/// Where the film puts one ramp: the offset that the steps around it want, and its standard deviation.
struct RampFit {
  double offset = 0, sigma = 0;
};

std::optional<RampFit> fit_ramp(const std::vector<Step>& steps, const Speed& speed, const Ramp& ramp, double offset,
                                double frame) {
  // Wide enough for a few frames at rest and a few at speed, and for the search.
  const double margin = 4 * frame, reach = 2.5 * frame, grid = std::min(1'000.0, frame / 16);
  const double begin = std::min(ramp.rest, ramp.full) - margin - offset, end = std::max(ramp.rest, ramp.full) + margin - offset;
  const auto first = std::lower_bound(steps.begin(), steps.end(), begin, [](const Step& s, double t) { return s.begin < t; });
  auto last = first;
  while (last != steps.end() && last->end <= end) ++last;
  const std::span<const Step> near(first, last);
  constexpr std::size_t fewest = 6;
  if (near.size() < fewest) return std::nullopt;
  for (std::size_t i = 0; i + 1 < near.size(); ++i) {
    if (near[i + 1].begin - near[i].end > frame) return std::nullopt;  // frames of which nothing is known
  }

  std::vector<double> left;
  std::size_t best = 0;
  const auto count = static_cast<std::size_t>(2 * reach / grid) + 1;
  const auto offset_at = [&](std::size_t i) { return offset - reach + grid * static_cast<double>(i); };
  for (std::size_t i = 0; i < count; ++i) {
    left.push_back(fit_amplitude(near, speed, offset_at(i)).left);
    if (left[i] < left[best]) best = i;
  }
  if (best == 0 || best + 1 == count || !std::isfinite(left[best])) return std::nullopt;
  // Over half a frame each way: the sum is no smooth parabola from one frame to the next.
  const auto wide = std::max<std::size_t>(1, static_cast<std::size_t>(0.25 * frame / grid));
  if (best < wide || best + wide >= count || !std::isfinite(left[best - wide]) || !std::isfinite(left[best + wide]))
    return std::nullopt;
  const double bend = (left[best - wide] - 2 * left[best] + left[best + wide]) /
                      (grid * grid * static_cast<double>(wide) * static_cast<double>(wide));
  if (!(bend > 0)) return std::nullopt;
  const AmplitudeFit fit = fit_amplitude(near, speed, offset_at(best));
  constexpr int parameters = 3;
  const double variance = fit.left / std::max(1, fit.steps - parameters);
  return RampFit{offset_at(best) + grid * extreme_of(left[best - 1], left[best], left[best + 1]), std::sqrt(2 * variance / bend)};
}

/// Where the film puts a motion, in microseconds from the film's first frame and the speed's first value.
struct MotionFit {
  double speed_time = 0, offset = 0, sigma = 0;
  std::optional<double> start, stop;  ///< offsets
};

std::optional<MotionFit> fit_motion(const std::vector<Step>& steps, const Speed& speed, const Motion& motion, double offset,
                                    double frame) {
  const auto fitted = [&](const std::optional<Ramp>& ramp) {
    return ramp ? fit_ramp(steps, speed, *ramp, offset, frame) : std::nullopt;
  };
  const std::optional<RampFit> start = fitted(motion.start), stop = fitted(motion.stop);
  if (start && stop) {
    const double apart = 0.5 * (start->offset - stop->offset), usual = frame / 32;
    const double misfit = (apart * apart + 2 * usual * usual) / 3;
    return MotionFit{.speed_time = 0.5 * (motion.start->middle() + motion.stop->middle()),
                     .offset = 0.5 * (start->offset + stop->offset),
                     .sigma = std::sqrt(0.25 * (start->sigma * start->sigma + stop->sigma * stop->sigma) + misfit),
                     .start = start->offset,
                     .stop = stop->offset};
  }
  if (!start && !stop) return std::nullopt;
  const RampFit& only = start ? *start : *stop;
  MotionFit fit{.speed_time = (start ? *motion.start : *motion.stop).middle(),
                .offset = only.offset,
                .sigma = std::hypot(only.sigma, frame / 16),
                .start = {},
                .stop = {}};
  (start ? fit.start : fit.stop) = only.offset;
  return fit;
}

/// Steps [first, last] of a film in which something moves.
struct Stretch {
  std::size_t first = 0, last = 0;
};

/// A step's change in standard deviations of the film's noise.
double size_of(const MotionStep& step, double noise) {
  return step.energy * 1e-6 * static_cast<double>((step.end - step.begin).count()) / noise;
}

/// The median over a stretch.
double usual_of(const MotionEnergy& energy, const Stretch& stretch, double MotionStep::*value) {
  std::vector<double> values;
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) values.push_back(energy.steps[i].*value);
  return upper_median(values);
}

std::vector<Stretch> stretches_in(const MotionEnergy& energy) {
  constexpr double enter = 10.0, leave = 2.5;
  constexpr microseconds merge = 80ms;
  std::vector<Stretch> stretches;
  const std::vector<MotionStep>& steps = energy.steps;
  for (std::size_t i = 0; i < steps.size();) {
    if (size_of(steps[i], energy.noise) < leave) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    double largest = 0;
    for (; i < steps.size() && size_of(steps[i], energy.noise) >= leave; ++i)
      if (!steps[i].doubtful) largest = std::max(largest, size_of(steps[i], energy.noise));
    if (largest < enter) continue;
    if (!stretches.empty() && steps[begin].begin - steps[stretches.back().last].end <= merge) {
      stretches.back().last = i - 1;
    } else {
      stretches.push_back({begin, i - 1});
    }
  }
  // Coders go on mending what has moved: such steps at the ends are no motion.
  constexpr double least = 0.03;
  for (Stretch& stretch : stretches) {
    const double limit = least * usual_of(energy, stretch, &MotionStep::energy);
    while (steps[stretch.first].energy < limit) ++stretch.first;
    while (steps[stretch.last].energy < limit) --stretch.last;
  }
  return stretches;
}

/// On the video's clock.
struct VideoSpan {
  VideoTime low{}, at{}, high{};
};

/// The steps at one end of a stretch, in microseconds into the motion from the outermost boundary between what rests and moves.
struct Edge {
  VideoTime origin{};
  double sign = 1;          ///< 1 at a start; -1 at an end, where time runs backwards
  std::vector<Step> steps;  ///< ascending
  double length = 0;        ///< of the outermost step that moves
  double unseen = 0;        ///< share of the usual speed at which too little changes in a step to be seen
};

/// The share of its usual speed at which too little changes in a step to be seen.
double unseen_share(const MotionEnergy& energy, const Stretch& stretch) {
  return energy.threshold / std::max(usual_of(energy, stretch, &MotionStep::strongest), energy.threshold);
}

/// Some steps that rest, those in which it gets faster, and two more.
Edge edge_of(const MotionEnergy& energy, const Stretch& stretch, bool is_start) {
  constexpr std::size_t at_rest = 3, at_speed = 2;
  constexpr double fast = 0.8;
  const std::vector<MotionStep>& steps = energy.steps;
  const double usual = usual_of(energy, stretch, &MotionStep::energy);

  Edge edge;
  edge.unseen = unseen_share(energy, stretch);
  edge.sign = is_start ? 1 : -1;
  edge.origin = is_start ? steps[stretch.first].begin : steps[stretch.last].end;
  const std::size_t count = stretch.last - stretch.first + 1;
  const auto outermost = static_cast<std::ptrdiff_t>(is_start ? stretch.first : stretch.last);
  const std::ptrdiff_t inwards = is_start ? 1 : -1;
  const auto add = [&](std::ptrdiff_t k) {
    const MotionStep& step = steps[static_cast<std::size_t>(outermost + inwards * k)];
    const double one = edge.sign * static_cast<double>((step.begin - edge.origin).count());
    const double other = edge.sign * static_cast<double>((step.end - edge.origin).count());
    edge.steps.push_back({std::min(one, other), std::max(one, other), step.energy});
  };
  for (auto k = -static_cast<std::ptrdiff_t>(at_rest); k < 0; ++k) {
    const std::ptrdiff_t i = outermost + inwards * k;
    if (i >= 0 && i < static_cast<std::ptrdiff_t>(steps.size())) add(k);
  }
  std::size_t fast_steps = 0;
  for (std::size_t k = 0; k < count && fast_steps <= at_speed; ++k) {
    add(static_cast<std::ptrdiff_t>(k));
    if (k == 0) edge.length = edge.steps.back().length();
    if (edge.steps.back().energy >= fast * usual || fast_steps > 0) ++fast_steps;
  }
  return edge;
}

/// The mean over [begin, end] of a speed that is 0 until `onset`, grows evenly for `ramp`, and is 1 from then on.
double mean_of_ramp(double begin, double end, double onset, double ramp) {
  const auto way = [&](double t) {
    const double u = t - onset;
    if (u <= 0) return 0.0;
    return u < ramp ? 0.5 * u * u / ramp : u - 0.5 * ramp;
  };
  return (way(end) - way(begin)) / (end - begin);
}

/// When a motion starts, or ends, going backwards: from rest it gets faster evenly until it moves as it then does. The best fit,
/// and what fits nearly as well.
VideoSpan span_of(const MotionEnergy& energy, const Stretch& stretch, bool is_start) {
  constexpr double grid = 1'000, ramp_grid = 8'000, longest_ramp = 320'000;
  constexpr double usual_misfit = 0.05;  // of the speed
  constexpr double within_95 = 3.84;
  const Edge edge = edge_of(energy, stretch, is_start);
  const double frame = static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
  const double earliest = -1.5 * frame, latest = edge.length;
  std::vector<double> left;  // the least over all ramps
  double all_least = std::numeric_limits<double>::infinity(), best_onset = 0, best_ramp = 0, best_amplitude = 0;
  for (double onset = earliest; onset <= latest; onset += grid) {
    double least = std::numeric_limits<double>::infinity();
    for (double ramp = 0; ramp <= longest_ramp; ramp += ramp_grid) {
      double ee = 0, em = 0, mm = 0;
      for (const Step& step : edge.steps) {
        const double m = mean_of_ramp(step.begin, step.end, onset, ramp);
        ee += step.energy * step.energy;
        em += step.energy * m;
        mm += m * m;
      }
      if (!(em > 0)) continue;
      const double rest = ee - em * em / mm;
      least = std::min(least, rest);
      if (rest < all_least) {
        all_least = rest;
        best_onset = onset;
        best_ramp = ramp;
        best_amplitude = em / mm;
      }
    }
    left.push_back(least);
  }
  const double noise = 1e6 * energy.noise / frame;
  const auto freedom = static_cast<double>(std::max<std::size_t>(edge.steps.size(), 4) - 3);
  const double variance = std::max({all_least / freedom, noise * noise, std::pow(usual_misfit * best_amplitude, 2)});
  double low = best_onset, high = best_onset;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i] > all_least + within_95 * variance) continue;
    low = std::min(low, earliest + grid * static_cast<double>(i));
    high = std::max(high, earliest + grid * static_cast<double>(i));
  }
  // What is too slow to be seen comes before: of a step, and of the time in which it gets faster. Mostly less than half of it.
  constexpr double usual_share = 0.4;
  const double unseen = edge.unseen * (frame + best_ramp);
  best_onset -= usual_share * unseen;
  low -= unseen;
  const auto time_of = [&](double t) { return edge.origin + microseconds{std::llround(edge.sign * t)}; };
  return {time_of(is_start ? low : high), time_of(best_onset), time_of(is_start ? high : low)};
}

VideoSpan start_of(const MotionEnergy& energy, const Stretch& stretch) { return span_of(energy, stretch, true); }
VideoSpan end_of(const MotionEnergy& energy, const Stretch& stretch) { return span_of(energy, stretch, false); }

/// A stretch whose ends are known.
struct FilmedMotion {
  VideoSpan start, end;
  double energy = 0;  ///< mean
  bool start_cut = false, end_cut = false, faint = false;
};

FilmedMotion filmed_motion(const MotionEnergy& energy, const Stretch& stretch) {
  constexpr double faint = 0.65;
  double sum = 0;
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) sum += energy.steps[i].energy;
  return {.start = start_of(energy, stretch),
          .end = end_of(energy, stretch),
          .energy = sum / static_cast<double>(stretch.last - stretch.first + 1),
          .start_cut = stretch.first == 0,
          .end_cut = stretch.last + 1 == energy.steps.size(),
          .faint = unseen_share(energy, stretch) > faint};
}

/// Of a motion's start or end in the film against a burst's.
double sigma_against_burst(const VideoSpan& span) {
  constexpr double of_burst = 15'000;
  return std::hypot(of_burst, 0.5 / normal_95 * static_cast<double>((span.high - span.low).count()));
}

double saturating_distance(std::int64_t a, std::int64_t b) {
  return std::abs(static_cast<double>(a > b ? saturating_subtract(a, b) : saturating_subtract(b, a)));
}

/// The burst that ends with a motion of the film, and may have started with it.
struct BurstFit {
  const SeenBurst* burst = nullptr;
  bool starts_too = false;
  double score = 0;  ///< 0 to 1 for its end, as much again for its start
};

/// @param bursts  by their ends
BurstFit fit_of(const FilmedMotion& motion, const std::vector<SeenBurst>& bursts, std::int64_t offset) {
  constexpr double farthest = 3;  // standard deviations
  if (motion.end_cut) return {};
  const auto camera_of = [&](const VideoSpan& span) { return CameraTime{microseconds{saturating_add(us_of(span.at), offset)}}; };
  const auto apart = [](CameraTime one, CameraTime other, double sigma) {
    return static_cast<double>(between(one, other).count()) / sigma;
  };
  const CameraTime end = camera_of(motion.end);
  auto burst = std::lower_bound(bursts.begin(), bursts.end(), end, [](const SeenBurst& b, CameraTime t) { return b.end < t; });
  if (burst != bursts.begin() && (burst == bursts.end() || between(end, burst->end) > between((burst - 1)->end, end))) --burst;
  const double end_apart = apart(end, burst->end, sigma_against_burst(motion.end));
  if (std::abs(end_apart) > farthest) return {};
  // Whatever fires, moves.
  const double start_late = apart(burst->start, camera_of(motion.start), sigma_against_burst(motion.start));
  if (start_late > farthest && !motion.start_cut) return {};
  const bool starts_too = std::abs(start_late) <= farthest && !motion.start_cut;
  const auto likely = [](double x) { return std::exp(-0.5 * x * x); };
  return {&*burst, starts_too, likely(end_apart) * (1 + (starts_too ? likely(start_late) : 0.0))};
}

/// The offset that the bursts found at `offset` want.
std::int64_t settled_offset(const std::vector<FilmedMotion>& filmed, const std::vector<SeenBurst>& bursts, std::int64_t offset) {
  double weights = 0, sum = 0;
  const auto add = [&](CameraTime camera, const VideoSpan& video) {
    const double weight = std::pow(sigma_against_burst(video), -2);
    weights += weight;
    sum += weight * static_cast<double>(saturating_subtract(saturating_subtract(us_of(camera), us_of(video.at)), offset));
  };
  for (const FilmedMotion& motion : filmed) {
    const BurstFit found = fit_of(motion, bursts, offset);
    if (found.burst == nullptr) continue;
    add(found.burst->end, motion.end);
    if (found.starts_too) add(found.burst->start, motion.start);
  }
  return weights > 0 ? saturating_add(offset, std::llround(sum / weights)) : offset;
}

/// The share of the bursts' time in which something moves in the film, times the share of the film's energy with which the skin
/// fires.
double share_in_both(const std::vector<FilmedMotion>& filmed, const std::vector<SeenBurst>& bursts, std::int64_t offset,
                     const MotionEnergy& energy) {
  const auto overlap = [](std::int64_t a_begin, std::int64_t a_end, std::int64_t b_begin, std::int64_t b_end) {
    return static_cast<double>(
        std::max<std::int64_t>(0, saturating_subtract(std::min(a_end, b_end), std::max(a_begin, b_begin))));
  };
  double firing = 0, firing_both = 0, moving = 0, moving_both = 0;
  for (const FilmedMotion& motion : filmed) {
    moving += motion.energy * static_cast<double>(saturating_subtract(us_of(motion.end.at), us_of(motion.start.at)));
  }
  for (const SeenBurst& burst : bursts) {
    const std::int64_t begin = saturating_subtract(us_of(burst.start), offset),
                       end = saturating_subtract(us_of(burst.end), offset);
    firing += overlap(begin, end, us_of(energy.begin()), us_of(energy.end()));
    for (const FilmedMotion& motion : filmed) {
      const double both = overlap(begin, end, us_of(motion.start.at), us_of(motion.end.at));
      firing_both += both;
      moving_both += motion.energy * both;
    }
  }
  return firing > 0 && moving > 0 ? firing_both / firing * moving_both / moving : 0.0;
}

/// With the line through its anchors.
VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy) {
  const VideoTime middle = energy.begin() + (energy.end() - energy.begin()) / 2;
  ClockFitOptions options;
  options.middle_us = us_of(middle);
  ClockFit line = fit_clock(fit.anchors, us_of(energy.begin()), options);
  fit.clock = std::move(line.clock);
  fit.refused = std::move(line.refused);
  return fit;
}

}  // namespace

SeenMotion seen_motion(const ArmMotion& motion, const FittedClock& robot_clock) {
  SeenMotion seen;
  if (motion.velocity.size() < 2) return seen;
  std::vector<double> speeds, known;
  for (std::size_t i = 0; i < motion.velocity.size(); ++i) {
    const auto& v = motion.velocity[i];
    speeds.push_back(std::hypot(v[0], v[1], v[2]));
    if (motion.known[i]) known.push_back(speeds.back());
  }
  if (known.empty()) return seen;
  // The magnitude of three noisy components has a median of 1.54 of their standard deviations; the arm rests mostly.
  constexpr double median_of_noise = 1.54, beyond_noise = 5;
  const double limit = upper_median(known) * (median_of_noise + beyond_noise) / median_of_noise;

  const ClockRelation& clock = robot_clock.relation;
  seen.begin = clock.camera_from(motion.begin);
  seen.step = motion.step;
  seen.sigma_us =
      0.5 / normal_95 * static_cast<double>(saturating_subtract(robot_clock.offset_high_us, robot_clock.offset_low_us));
  const CameraTime end = clock.camera_from(motion.time_of(motion.velocity.size() - 1));
  const auto step_us = static_cast<double>(motion.step.count());
  for (CameraTime t = seen.begin; t <= end && seen.speed.size() < motion.velocity.size() + motion.velocity.size() / 1000;
       t = after(t, seen.step)) {
    const double place = static_cast<double>(saturating_subtract(clock.clock_us_from(t), us_of(motion.begin))) / step_us;
    const std::size_t i = std::min(static_cast<std::size_t>(std::max(place, 0.0)), speeds.size() - 2);
    const double share = std::clamp(place - static_cast<double>(i), 0.0, 1.0);
    const double speed = motion.known[i] ? speeds[i] + share * (speeds[i + 1] - speeds[i]) : 0.0;
    seen.speed.push_back(speed > limit ? speed : 0.0);
  }
  return seen;
}

VideoClockFit fit_video_clock(const MotionEnergy& energy, const SeenMotion& seen, const VideoClockOptions& options) {
  VideoClockFit fit;
  const auto refuse = [&](std::string reason) {
    fit.refused = std::move(reason);
    return fit;
  };
  const std::vector<Step> steps = steps_of(energy);
  constexpr std::size_t fewest_steps = 8;
  if (steps.size() < fewest_steps)
    return refuse(fmt::format("the film has {} steps from frame to frame; expected {} at least", steps.size(), fewest_steps));
  if (seen.speed.size() < 2 || seen.step.count() <= 0) return refuse("nothing is known of what the film should have seen");
  const Speed speed(seen);
  if (!(speed.peak() > 0)) return refuse("nothing moves that the film should have seen");
  if (std::none_of(steps.begin(), steps.end(), [](const Step& step) { return step.energy > 0; }))
    return refuse("nothing moves in the film");

  // Offsets are those of the speed's begin against the film's.
  const double film_us = steps.back().end;
  double from = -film_us, to = speed.length();
  std::int64_t apart_us = 0;
  if (__builtin_sub_overflow(us_of(seen.begin), us_of(energy.begin()), &apart_us))
    return refuse("the two clocks lie further apart than 64 bits of microseconds");
  if (options.coarse_offset_us) {
    const auto coarse = static_cast<double>(saturating_subtract(*options.coarse_offset_us, apart_us));
    const auto search = static_cast<double>(options.search.count());
    from = std::max(from, coarse - search);
    to = std::min(to, coarse + search);
    if (from > to) return refuse("by the hosts' times film and recording do not overlap");
  }
  constexpr std::size_t most_steps = 2048;
  const std::vector<Step> fewer = fewer_steps(steps, most_steps);
  const double frame = static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
  const double grid = std::max(0.5 * frame, (film_us + speed.length()) / (4.0 * most_steps));
  const Match coarse = coarse_match(fewer, speed, from, to, grid);
  const Match match = fine_match(fewer, speed, coarse, grid);
  fit.likeness = match.found.correlation;
  fit.ambiguity = match.second > 0 ? std::min(match.found.score / match.second, no_other) : no_other;
  if (fit.likeness < options.least_likeness) {
    return refuse(fmt::format(
        "what moves in the film is not like what should have moved: their correlation is {:.2f} at most; expected {:.2f}",
        std::max(fit.likeness, 0.0), options.least_likeness));
  }
  if (fit.ambiguity < options.least_ambiguity) {
    return refuse(fmt::format("the film matches at two places: the better is only {:.2f} times as good; expected {:.2f}",
                              fit.ambiguity, options.least_ambiguity));
  }

  std::vector<MotionFit> motions;
  for (const Motion& motion : motions_in(speed)) {
    if (const std::optional<MotionFit> found = fit_motion(steps, speed, motion, match.offset, frame)) motions.push_back(*found);
  }
  if (motions.empty()) return refuse("the film shows neither start nor stop of what should have moved");
  double apart = 0;
  for (const MotionFit& motion : motions) {
    if (motion.start && motion.stop) apart = std::max(apart, std::abs(*motion.start - *motion.stop));
  }
  if (apart > options.most_disagreement_us) {
    return refuse(fmt::format("start and stop of a motion place the film {:.0f} ms apart; expected {:.0f} ms at most",
                              1e-3 * apart, 1e-3 * options.most_disagreement_us));
  }
  for (const MotionFit& motion : motions) {
    const std::int64_t at_us = std::llround(motion.speed_time);
    fit.anchors.push_back({.clock_us = saturating_add(us_of(energy.begin()), at_us - std::llround(motion.offset)),
                           .camera = after(seen.begin, microseconds{at_us}),
                           .sigma_us = motion.sigma,
                           .kind = AnchorKind::film_of_arm,
                           .bias_us = seen.sigma_us});
  }
  return with_clock(std::move(fit), energy);
}

VideoClockFit fit_video_clock(const MotionEnergy& energy, std::span<const SeenBurst> bursts, const VideoClockOptions& options) {
  VideoClockFit fit;
  const auto refuse = [&](std::string reason) {
    fit.refused = std::move(reason);
    return fit;
  };
  const std::vector<Stretch> stretches = stretches_in(energy);
  if (stretches.empty()) return refuse("nothing moves in the film");
  if (bursts.empty()) return refuse("the events show nothing that moves");

  // Of a film with hundreds of motions so many will do.
  constexpr std::size_t most = 200;
  std::vector<FilmedMotion> filmed;
  for (const Stretch& stretch : stretches) {
    if (filmed.size() < most) filmed.push_back(filmed_motion(energy, stretch));
  }
  std::vector<SeenBurst> seen(bursts.begin(), bursts.begin() + static_cast<std::ptrdiff_t>(std::min(bursts.size(), most)));
  std::sort(seen.begin(), seen.end(), [](const SeenBurst& one, const SeenBurst& other) { return one.end < other.end; });

  struct Candidate {
    std::int64_t offset = 0;
    double score = 0;
  };
  std::vector<Candidate> candidates;
  const auto add_candidate = [&](CameraTime camera, VideoTime video) {
    Candidate candidate{saturating_subtract(us_of(camera), us_of(video)), 0};
    if (options.coarse_offset_us &&
        saturating_distance(candidate.offset, *options.coarse_offset_us) > static_cast<double>(options.search.count()))
      return;
    candidate.offset = settled_offset(filmed, seen, candidate.offset);
    for (const FilmedMotion& other : filmed) candidate.score += fit_of(other, seen, candidate.offset).score;
    candidate.score *= share_in_both(filmed, seen, candidate.offset, energy);
    candidates.push_back(candidate);
  };
  for (const FilmedMotion& motion : filmed) {
    for (const SeenBurst& burst : seen) add_candidate(burst.end, motion.end.at);
  }
  const auto best = std::max_element(candidates.begin(), candidates.end(),
                                     [](const Candidate& one, const Candidate& other) { return one.score < other.score; });
  if (best == candidates.end()) return refuse("by the hosts' times no motion of the film is near a burst of events");
  constexpr double not_same_us = 120'000;
  double second = 0;
  for (const Candidate& other : candidates) {
    if (saturating_distance(other.offset, best->offset) > not_same_us) second = std::max(second, other.score);
  }
  fit.likeness = 0.5 * best->score / static_cast<double>(filmed.size());
  fit.ambiguity = second > 0 ? std::min(best->score / second, no_other) : no_other;
  if (fit.ambiguity < options.least_ambiguity) {
    return refuse(fmt::format(
        "the film matches the bursts of events at two places: the better is only {:.2f} times as good; expected {:.2f}",
        fit.ambiguity, options.least_ambiguity));
  }
  constexpr double common_sigma_us = 10'000;
  for (const FilmedMotion& motion : filmed) {
    const BurstFit found = fit_of(motion, seen, best->offset);
    if (found.burst == nullptr) continue;
    const auto add = [&](const VideoSpan& video, CameraTime camera) {
      fit.anchors.push_back({.clock_us = us_of(video.at),
                             .camera = camera,
                             .sigma_us = sigma_against_burst(video),
                             .kind = AnchorKind::film_of_skin,
                             .bias_us = common_sigma_us});
    };
    if (found.starts_too) add(motion.start, found.burst->start);
    add(motion.end, found.burst->end);
  }
  return with_clock(std::move(fit), energy);
}

std::vector<VideoMotion> video_motions(const MotionEnergy& energy, const FittedClock& clock) {
  const double clock_us = 0.5 * static_cast<double>(saturating_subtract(clock.offset_high_us, clock.offset_low_us));
  // The clock's error and where in its step a motion starts are independent.
  const auto uncertain = [&](const VideoSpan& span) {
    const auto reach = [&](microseconds own) {
      return microseconds{std::llround(std::hypot(static_cast<double>(own.count()), clock_us))};
    };
    const CameraTime at = clock.relation.camera_from(span.at);
    return UncertainTime{at, before(at, reach(span.at - span.low)), after(at, reach(span.high - span.at))};
  };
  std::vector<VideoMotion> motions;
  for (const Stretch& stretch : stretches_in(energy)) {
    const FilmedMotion filmed = filmed_motion(energy, stretch);
    motions.push_back({.start = uncertain(filmed.start),
                       .end = uncertain(filmed.end),
                       .energy = filmed.energy,
                       .start_cut = filmed.start_cut,
                       .end_cut = filmed.end_cut,
                       .faint = filmed.faint});
  }
  return motions;
}

namespace {

/// How far apart two intervals are; 0 where they overlap.
microseconds apart(const UncertainTime& a, const UncertainTime& b) {
  return std::max({between(a.high, b.low), between(b.high, a.low), 0us});
}

std::optional<UncertainTime> nearest(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds most,
                                     UncertainTime VideoMotion::*end, bool VideoMotion::*cut) {
  std::optional<UncertainTime> best;
  for (const VideoMotion& motion : motions) {
    const UncertainTime& found = motion.*end;
    if (motion.*cut || motion.faint || apart(found, t) > most) continue;
    if (!best || std::chrono::abs(between(t.at, found.at)) < std::chrono::abs(between(t.at, best->at))) best = found;
  }
  return best;
}

}  // namespace

std::optional<UncertainTime> video_start_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart) {
  return nearest(motions, t, apart, &VideoMotion::start, &VideoMotion::start_cut);
}

std::optional<UncertainTime> video_end_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart) {
  return nearest(motions, t, apart, &VideoMotion::end, &VideoMotion::end_cut);
}

std::optional<bool> video_saw_motion(const MotionEnergy& energy, const FittedClock& clock, CameraTime begin, CameraTime end) {
  if (energy.steps.empty() || begin >= end) return std::nullopt;
  constexpr std::int64_t longest_in_frames = 4;
  const auto camera_from = [&](VideoTime t) { return clock.relation.camera_from(t); };
  if (camera_from(energy.begin()) > begin || camera_from(energy.end()) < end) return std::nullopt;
  std::optional<VideoTime> last;
  for (const MotionStep& step : energy.steps) {
    const CameraTime from = camera_from(last.value_or(step.begin)), to = camera_from(step.end);
    last = step.end;
    if (to <= begin || from >= end) continue;
    if (to - from >= longest_in_frames * energy.median_step) return std::nullopt;
  }
  const std::vector<VideoMotion> motions = video_motions(energy, clock);
  return std::any_of(motions.begin(), motions.end(),
                     [&](const VideoMotion& motion) { return motion.start.at < end && motion.end.at > begin; });
}

}  // namespace tactile
