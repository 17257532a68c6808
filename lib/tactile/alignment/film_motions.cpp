#include "tactile/alignment/film_motions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {
namespace {

/// Steps [first, last] of a film in which something moves.
struct StepRange {
  std::size_t first = 0, last = 0;
};

/// A step's change in standard deviations of the film's noise.
double size_of(const MotionStep& step, double noise) {
  return step.energy * 1e-6 * static_cast<double>((step.end - step.begin).count()) / noise;
}

/// The median over a stretch.
double usual_of(const MotionEnergy& energy, const StepRange& stretch, double MotionStep::*value) {
  std::vector<double> values;
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) values.push_back(energy.steps[i].*value);
  return median(values);
}

std::vector<StepRange> stretches_in(const MotionEnergy& energy) {
  constexpr double enter = 10.0, leave = 2.5;
  constexpr microseconds merge = 80ms;
  std::vector<StepRange> stretches;
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
  // Coders continue to correct what has moved: such steps at the ends are no motion.
  constexpr double least = 0.03;
  for (StepRange& stretch : stretches) {
    const double limit = least * usual_of(energy, stretch, &MotionStep::energy);
    while (steps[stretch.first].energy < limit) ++stretch.first;
    while (steps[stretch.last].energy < limit) --stretch.last;
  }
  return stretches;
}

/// The steps at one end of a stretch, in microseconds into the motion from the outermost boundary between rest and motion.
struct Edge {
  VideoTime origin{};
  double sign = 1;              ///< 1 at a start; -1 at an end, where time runs backwards
  std::vector<FilmStep> steps;  ///< ascending
  double length = 0;            ///< of the outermost step that moves
};

/// The share of its usual speed at which too little changes in a step to be seen.
double unseen_share(const MotionEnergy& energy, const StepRange& stretch) {
  return energy.threshold / std::max(usual_of(energy, stretch, &MotionStep::strongest), energy.threshold);
}

/// Some steps at rest, those in which the motion speeds up, and two more.
Edge edge_of(const MotionEnergy& energy, const StepRange& stretch, bool is_start) {
  constexpr std::ptrdiff_t at_rest = 3;
  constexpr std::size_t at_speed = 2;
  constexpr double fast = 0.8;
  const std::vector<MotionStep>& steps = energy.steps;
  const double usual = usual_of(energy, stretch, &MotionStep::energy);
  Edge edge;
  edge.sign = is_start ? 1 : -1;
  edge.origin = is_start ? steps[stretch.first].begin : steps[stretch.last].end;
  const auto outermost = static_cast<std::ptrdiff_t>(is_start ? stretch.first : stretch.last);
  const std::ptrdiff_t inwards = is_start ? 1 : -1;
  const auto add = [&](std::ptrdiff_t i) {
    const MotionStep& step = steps[static_cast<std::size_t>(i)];
    const double one = edge.sign * static_cast<double>((step.begin - edge.origin).count());
    const double other = edge.sign * static_cast<double>((step.end - edge.origin).count());
    edge.steps.push_back({std::min(one, other), std::max(one, other), step.energy});
  };
  for (std::ptrdiff_t k = -at_rest; k < 0; ++k) {
    const std::ptrdiff_t i = outermost + inwards * k;
    if (i >= 0 && i < static_cast<std::ptrdiff_t>(steps.size())) add(i);
  }
  const auto count = static_cast<std::ptrdiff_t>(stretch.last - stretch.first + 1);
  std::size_t fast_steps = 0;
  for (std::ptrdiff_t k = 0; k < count && fast_steps <= at_speed; ++k) {
    add(outermost + inwards * k);
    if (k == 0) edge.length = edge.steps.back().length();
    if (edge.steps.back().energy >= fast * usual || fast_steps > 0) ++fast_steps;
  }
  return edge;
}

/// The mean over [begin, end] of a speed that is 0 until `onset`, grows evenly for `ramp`, and is 1 from then on.
double mean_of_ramp(double begin, double end, double onset, double ramp) {
  const auto integral = [&](double t) {
    const double u = t - onset;
    if (u <= 0) return 0.0;
    return u < ramp ? 0.5 * u * u / ramp : u - 0.5 * ramp;
  };
  return (integral(end) - integral(begin)) / (end - begin);
}

/// The best ramp of an edge, and for each onset on the grid what the best ramp leaves.
struct RampFit {
  double left = std::numeric_limits<double>::infinity();  ///< sum of squares
  double onset = 0, ramp = 0, amplitude = 0;
  std::vector<double> left_at;
};

RampFit fit_ramp(const Edge& edge, double earliest, double grid) {
  constexpr double ramp_grid = 8'000, longest_ramp = 320'000;
  RampFit best;
  for (double onset = earliest; onset <= edge.length; onset += grid) {  // NOLINT(clang-analyzer-security.FloatLoopCounter)
    double least = std::numeric_limits<double>::infinity();
    for (double ramp = 0; ramp <= longest_ramp; ramp += ramp_grid) {  // NOLINT(clang-analyzer-security.FloatLoopCounter)
      double ee = 0, em = 0, mm = 0;
      for (const FilmStep& step : edge.steps) {
        const double m = mean_of_ramp(step.begin, step.end, onset, ramp);
        ee += step.energy * step.energy;
        em += step.energy * m;
        mm += m * m;
      }
      if (!(em > 0)) continue;
      const double left = ee - em * em / mm;
      least = std::min(least, left);
      if (left < best.left) best = {left, onset, ramp, em / mm, std::move(best.left_at)};
    }
    best.left_at.push_back(least);
  }
  return best;
}

/// When a motion starts; or ends, with time backwards: the best fit, and what fits nearly as well.
VideoSpan span_of(const MotionEnergy& energy, const StepRange& stretch, bool is_start) {
  constexpr double grid = 1'000, usual_misfit = 0.05;  // of the speed
  constexpr double within_95 = 3.84;
  const Edge edge = edge_of(energy, stretch, is_start);
  const double frame = static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
  const double earliest = -1.5 * frame, noise = 1e6 * energy.noise / frame;
  const RampFit best = fit_ramp(edge, earliest, grid);
  const auto freedom = static_cast<double>(std::max<std::size_t>(edge.steps.size(), 4) - 3);
  const double variance = std::max({best.left / freedom, noise * noise, std::pow(usual_misfit * best.amplitude, 2)});
  double low = best.onset, high = best.onset;
  for (std::size_t i = 0; i < best.left_at.size(); ++i) {
    if (best.left_at[i] > best.left + within_95 * variance) continue;
    low = std::min(low, earliest + grid * static_cast<double>(i));
    high = std::max(high, earliest + grid * static_cast<double>(i));
  }
  // The motion too slow to be seen comes before: a share of a step and of the ramp, mostly less than half of it.
  constexpr double usual_share = 0.4;
  const double unseen = unseen_share(energy, stretch) * (frame + best.ramp);
  const auto time_of = [&](double t) { return edge.origin + microseconds{std::llround(edge.sign * t)}; };
  return {time_of(is_start ? low - unseen : high), time_of(best.onset - usual_share * unseen),
          time_of(is_start ? high : low - unseen)};
}

/// How far apart two intervals are; 0 where they overlap.
microseconds distance(const UncertainTime& a, const UncertainTime& b) {
  return std::max({between(a.high, b.low), between(b.high, a.low), 0us});
}

}  // namespace

std::vector<FilmedMotion> filmed_motions(const MotionEnergy& energy, std::size_t most) {
  constexpr double faint = 0.65;
  std::vector<FilmedMotion> motions;
  for (const StepRange& stretch : stretches_in(energy)) {
    if (motions.size() == most) break;
    double sum = 0;
    for (std::size_t i = stretch.first; i <= stretch.last; ++i) sum += energy.steps[i].energy;
    motions.push_back({.start = span_of(energy, stretch, true),
                       .end = span_of(energy, stretch, false),
                       .energy = sum / static_cast<double>(stretch.last - stretch.first + 1),
                       .start_cut = stretch.first == 0,
                       .end_cut = stretch.last + 1 == energy.steps.size(),
                       .faint = unseen_share(energy, stretch) > faint});
  }
  return motions;
}

std::vector<VideoMotion> video_motions(const MotionEnergy& energy, const FittedClock& clock) {
  // The error of the clock and that of the film are independent.
  const auto uncertain = [&](const VideoSpan& span) {
    const CameraTime at = clock.relation.camera_from(span.at);
    const auto clock_us = static_cast<double>(clock.uncertainty_at(at).count());
    const auto reach = [&](microseconds own) {
      return microseconds{std::llround(std::hypot(static_cast<double>(own.count()), clock_us))};
    };
    return UncertainTime{at, before(at, reach(span.at - span.low)), after(at, reach(span.high - span.at))};
  };
  std::vector<VideoMotion> motions;
  for (const FilmedMotion& filmed : filmed_motions(energy, energy.steps.size())) {
    motions.push_back({.start = uncertain(filmed.start),
                       .end = uncertain(filmed.end),
                       .energy = filmed.energy,
                       .start_cut = filmed.start_cut,
                       .end_cut = filmed.end_cut,
                       .faint = filmed.faint});
  }
  return motions;
}

std::optional<UncertainTime> video_start_near(std::span<const VideoMotion> motions, const UncertainTime& t, microseconds apart) {
  std::optional<UncertainTime> best;
  for (const VideoMotion& motion : motions) {
    if (motion.start_cut || motion.faint || distance(motion.start, t) > apart) continue;
    if (!best || std::chrono::abs(between(t.at, motion.start.at)) < std::chrono::abs(between(t.at, best->at)))
      best = motion.start;
  }
  return best;
}

std::optional<UncertainTime> video_start_around(std::span<const VideoMotion> motions, const UncertainTime& onset) {
  const auto motion = std::find_if(motions.begin(), motions.end(), [&](const VideoMotion& one) {
    return !one.start_cut && one.start.low <= onset.high && one.end.high >= onset.low;
  });
  return motion == motions.end() ? std::nullopt : std::optional(motion->start);
}

}  // namespace tactile::alignment
