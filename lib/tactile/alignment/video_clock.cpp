#include "tactile/alignment/video_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tactile/core/robust_statistics.hpp"

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

}  // namespace

std::string set_ambiguity(VideoClockFit& fit, double best, double second, const VideoClockOptions& options) {
  constexpr double no_other = 99;
  fit.ambiguity = second > 0 ? std::min(best / second, no_other) : no_other;
  if (fit.ambiguity >= options.least_ambiguity) return {};
  return fmt::format("the film matches at two offsets: the better is only {:.2f} times as good; expected {:.2f}", fit.ambiguity,
                     options.least_ambiguity);
}

VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy) {
  constexpr double of_rates_ppm = 5'000, of_lost_frames_ppm = 14'000;
  const bool counted = counts_frames(energy);
  ClockFitOptions options;
  const auto [first, last] = std::minmax_element(fit.anchors.begin(), fit.anchors.end(),
                                                 [](const auto& a, const auto& b) { return a.clock_us < b.clock_us; });
  const std::int64_t span_us = saturating_subtract(last->clock_us, first->clock_us);
  const std::int64_t found_at_us = saturating_add(first->clock_us, span_us / 2);
  options.middle_us = found_at_us;
  // Motions over a minute show the drift themselves.
  if (span_us < options.drift_needs_span.count())
    options.usual_drift_ppm = std::hypot(of_rates_ppm, counted ? of_lost_frames_ppm : 0.0);
  ClockFit line = fit_clock(fit.anchors, us_of(energy.begin()), options);
  fit.clock = std::move(line.clock);
  fit.refused = std::move(line.refused);
  if (!fit.clock) return fit;
  fit.clock->found_at_us = found_at_us;
  if (fit.clock->relation.drift_ppm == 0) fit.clock->drift_within_ppm = normal_95 * options.usual_drift_ppm;
  if (counted) {
    const auto within = [&](VideoTime t) { return fit.clock->uncertainty_at(fit.clock->relation.camera_from(t)); };
    fit.remark = fmt::format(
        "the times of the film are even: they count its frames, and do not say when one was taken; they may be off by {:.0f} ms",
        1e-3 * static_cast<double>(std::max(within(energy.begin()), within(energy.end())).count()));
  }
  return fit;
}

}  // namespace tactile::alignment
