#include "tactile/alignment/video_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
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

VideoClockFit with_clock(VideoClockFit fit, const MotionEnergy& energy, double drift_ppm) {
  constexpr double of_counted_frames_ppm = 15'000;
  const bool counted = counts_frames(energy);
  const auto distance_us = [&](VideoTime t) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (const ClockAnchor& anchor : fit.anchors)
      least = std::min(least, std::abs(saturating_subtract(anchor.clock_us, us_of(t))));
    return least;
  };
  const VideoTime farthest = distance_us(energy.begin()) > distance_us(energy.end()) ? energy.begin() : energy.end();
  ClockFitOptions options{.middle_us = us_of(farthest)};
  options.usual_drift_ppm = std::hypot(options.usual_drift_ppm, drift_ppm, counted ? of_counted_frames_ppm : 0.0);
  ClockFit line = fit_clock(fit.anchors, us_of(energy.begin()), options);
  fit.clock = std::move(line.clock);
  fit.refused = std::move(line.refused);
  if (counted && fit.clock) {
    fit.remark = fmt::format(
        "the times of the film are even: they count its frames, and do not say when one was taken; its clock may be off by "
        "{:.0f} ms",
        1e-3 * static_cast<double>(fit.clock->uncertainty().count()));
  }
  return fit;
}

}  // namespace tactile::alignment
