#include "tactile/alignment/video_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/straight_line.hpp"

namespace tactile::alignment {
namespace {

/// Whether its times are those of a rate, such as index / 30: half of the steps or more are equal. Times that were measured vary
/// by more than rounding does.
bool counts_frames(const MotionEnergy& energy) {
  constexpr double rounding_us = 2;
  std::vector<double> lengths;
  for (const MotionStep& step : energy.steps) lengths.push_back(static_cast<double>((step.end - step.begin).count()));
  return median(distances_from(median(lengths), lengths)) <= rounding_us;
}

/// How much longer a time is on the camera's clock than on the film's, less 1, and its standard deviation.
struct Gradient {
  double value = 0, sigma = std::numeric_limits<double>::infinity();
};

/// By the distances between the arm's motions; infinitely uncertain if there is one.
Gradient gradient_of(const std::vector<ClockAnchor>& anchors) {
  std::vector<WeightedPoint> points;
  points.reserve(anchors.size());
  const ClockAnchor& first = anchors.front();
  for (const ClockAnchor& anchor : anchors) {
    const std::int64_t x = saturating_subtract(anchor.clock_us, first.clock_us);
    const std::int64_t y = saturating_subtract(between(first.camera, anchor.camera).count(), x);
    points.push_back({static_cast<double>(x), static_cast<double>(y), 1 / std::max(1.0, anchor.sigma_us * anchor.sigma_us)});
  }
  const StraightLine line = line_through(points);
  if (!(line.weighted_xx > 0)) return {};
  double misfit = 0;
  for (const WeightedPoint& p : points) misfit += p.weight * std::pow(p.y - line.at(p.x), 2);
  const double scatter = points.size() > 2 ? std::max(1.0, std::sqrt(misfit / static_cast<double>(points.size() - 2))) : 1.0;
  return {line.gradient, scatter / std::sqrt(line.weighted_xx)};
}

/// The rate of a film is the median of its steps.
double frames_per_s(const MotionEnergy& energy) {
  return 1e6 / static_cast<double>(std::max<std::int64_t>(energy.median_step.count(), 1));
}

/// Why the rate of counted times cannot be the film's: the motions would have another distance. Empty if it can.
std::string contradiction_of_rate(const MotionEnergy& energy, const Gradient& motions, double usual_drift) {
  constexpr double reject_beyond = 3;  // standard deviations
  if (std::abs(motions.value) <= reject_beyond * std::hypot(usual_drift, motions.sigma)) return {};
  return fmt::format(
      "the times of the film are even: they count {:.4g} frames/s, but by the distance of its motions it has about {:.3g} "
      "frames/s; expected times of the film's own rate",
      frames_per_s(energy), frames_per_s(energy) / (1 + motions.value));
}

std::string remark_on_counted(const MotionEnergy& energy, const FittedClock& clock, bool is_rate_seen) {
  const auto within = [&](VideoTime t) { return clock.uncertainty_at(clock.relation.camera_from(t)); };
  std::string remark = fmt::format(
      "the times of the film are even: they count its frames, and do not say when one was taken; they may be off by {:.0f} ms",
      1e-3 * static_cast<double>(std::max(within(energy.begin()), within(energy.end())).count()));
  if (is_rate_seen) return remark;
  return fmt::format("{}, or by more if the film was not taken at {:.4g} frames/s: its motions do not show its rate", remark,
                     frames_per_s(energy));
}

/// Of films, standard deviation.
double usual_drift_ppm_of(bool counts_frames) {
  constexpr double of_rates_ppm = 5'000, of_lost_frames_ppm = 14'000;
  return std::hypot(of_rates_ppm, counts_frames ? of_lost_frames_ppm : 0.0);
}

}  // namespace

std::string allow_for_drift(FittedClock& clock, const MotionEnergy& energy) {
  const bool counted = counts_frames(energy);
  clock.found_at_us = us_of(energy.begin() + (energy.end() - energy.begin()) / 2);
  clock.drift_within_ppm = normal_95 * usual_drift_ppm_of(counted);
  return counted ? remark_on_counted(energy, clock, false) : std::string();
}

VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy) {
  const bool counted = counts_frames(energy);
  const double usual_drift_ppm = usual_drift_ppm_of(counted);
  const Gradient motions = gradient_of(fit.anchors);
  if (counted) fit.refused = contradiction_of_rate(energy, motions, 1e-6 * usual_drift_ppm);
  if (!fit.refused.empty()) return fit;
  ClockFitOptions options;
  const auto [first, last] = std::minmax_element(fit.anchors.begin(), fit.anchors.end(),
                                                 [](const auto& a, const auto& b) { return a.clock_us < b.clock_us; });
  const std::int64_t span_us = saturating_subtract(last->clock_us, first->clock_us);
  const std::int64_t found_at_us = saturating_add(first->clock_us, span_us / 2);
  options.middle_us = found_at_us;
  // Motions over a minute show the drift themselves.
  if (span_us < options.drift_needs_span.count()) options.usual_drift_ppm = usual_drift_ppm;
  ClockFit line = fit_clock(fit.anchors, us_of(energy.begin()), options);
  fit.clock = std::move(line.clock);
  fit.refused = std::move(line.refused);
  if (!fit.clock) return fit;
  fit.clock->method = "the arm in the film: " + fit.clock->method;
  fit.clock->found_at_us = found_at_us;
  if (fit.clock->relation.drift_ppm == 0) fit.clock->drift_within_ppm = normal_95 * options.usual_drift_ppm;
  if (counted) fit.remark = remark_on_counted(energy, *fit.clock, motions.sigma < 1e-6 * usual_drift_ppm);
  return fit;
}

}  // namespace tactile::alignment
